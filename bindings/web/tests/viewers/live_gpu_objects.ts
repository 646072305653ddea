// Counts the buffers and textures that are alive on the GPU, by what pages call to make and free them.
const live = { buffers: new Set<object>(), textures: new Set<object>() };

type Method = (this: object, ...values: unknown[]) => object;

function wrap(prototype: object, name: string, then: (result: object, self: object, values: unknown[]) => void): void {
  const methods = prototype as Record<string, Method>, method = methods[name]!;
  methods[name] = function (...values) {
    const result = method.apply(this, values);
    then(result, this, values);
    return result;
  };
}

/** To be called before a viewer is made. */
export function watchGpu(): void {
  for (const { prototype } of [WebGL2RenderingContext, WebGLRenderingContext])
    for (const [kind, set] of [["Buffer", live.buffers], ["Texture", live.textures]] as const) {
      wrap(prototype, `create${kind}`, (made) => set.add(made));
      wrap(prototype, `delete${kind}`, (_, __, [gone]) => set.delete(gone as object));
    }
  if (!("GPUDevice" in globalThis)) return;
  const gpu = globalThis as unknown as Record<string, { prototype: object }>;
  for (const [kind, set] of [["Buffer", live.buffers], ["Texture", live.textures]] as const) {
    wrap(gpu["GPUDevice"]!.prototype, `create${kind}`, (made) => set.add(made));
    wrap(gpu[`GPU${kind}`]!.prototype, "destroy", (_, gone) => set.delete(gone));
  }
}

export const liveOnGpu = (): Record<string, number> =>
  ({ "buffers on the GPU": live.buffers.size, "textures on the GPU": live.textures.size });
