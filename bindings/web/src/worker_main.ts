// Runs in a worker: holds one face and answers the messages of worker.ts. The package has it as one script without
// imports (build.sh), which any tool may copy, and bundle as a script or as a module.
import { FaceBakerError } from "./errors.js";
import { loadWith, type Face } from "./face.js";
import { isNode, nodeModule } from "./platform.js";
import { outputBuffers, type Answer, type Message, type Request } from "./worker_messages.js";

type Post = (answer: Answer, transfer: readonly ArrayBuffer[]) => void;

let face: Face | null = null;

async function answer(request: Request, progress: (loaded: number, total: number) => void,
                      ): Promise<[unknown, ArrayBuffer[]]> {
  if (request.call === "load") {
    const { source, wasm, limits } = request;
    face = await loadWith(wasm, source, { limits, progress: request.progress ? progress : undefined });
    return [face.contents(), []];
  }
  if (!face) throw new FaceBakerError(1, "FB_ERROR_INVALID_ARGUMENT", "the face is disposed of");
  switch (request.call) {
    case "evaluate": {
      const { controls, positions } = request;
      face.evaluate(controls, positions);
      return [{ controls, positions }, [controls.buffer as ArrayBuffer, positions.buffer as ArrayBuffer]];
    }
    case "evaluateBatch": {
      const { controls, count, outputs } = request;
      face.evaluateBatch(controls, count, outputs);
      return [{ controls, outputs }, [controls.buffer as ArrayBuffer, ...outputBuffers(outputs)]];
    }
    case "evaluateMany": {
      face.evaluateMany(request.poses);
      const outputs = request.poses.map((pose) => pose.outputs);
      return [outputs, [...new Set(outputs.flatMap(outputBuffers))]];
    }
    case "coefficients": {
      const coefficients = face.coefficients(request.controls);
      return [coefficients, [coefficients.buffer as ArrayBuffer]];
    }
    case "expectedError":
      return [face.expectedError(request.controls), []];
    case "rowBlocks":
      return [face.rowBlocks, []];
    case "dispose":
      face.dispose();
      face = null;
      return [null, []];
  }
}

function listen(post: Post): (message: Message) => void {
  return ({ id, request }) => {
    answer(request, (loaded, total) => post({ id, loaded, total }, [])).then(
      ([result, transfer]) => post({ id, result }, transfer),
      (error: Error) => {
        const { message } = error;
        post({ id, error: error instanceof FaceBakerError
          ? { message, status: error.status, statusName: error.statusName } : { message } }, []);
      });
  };
}

interface Port {
  postMessage(message: unknown, transfer: readonly unknown[]): void;
  onmessage: ((event: MessageEvent) => void) | null;
}

// What arrives before this listens is kept.
if (isNode)
  void nodeModule("worker_threads").then(({ parentPort }) => {
    const receive = listen((message, transfer) => parentPort?.postMessage(message, transfer));
    parentPort?.on("message", (message) => receive(message as Message));
  });
else {
  const port = globalThis as unknown as Port;
  const receive = listen((message, transfer) => port.postMessage(message, transfer));
  port.onmessage = (event) => receive(event.data as Message);
}
