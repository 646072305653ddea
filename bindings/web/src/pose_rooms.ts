// What poses go through in the module's memory. All faces of a module share it, as one is posed at a time: so a face takes
// no more memory for its poses than the arrays that they are written into.
import type { Heap } from "./heap.js";
import { Room } from "./staging.js";

export class PoseRooms {
  /** An fb_batch_desc. */
  readonly desc: number;
  private readonly rooms = new Map<string, Room>();
  private users = 0;

  private constructor(private readonly heap: Heap) {
    this.desc = heap.allocate(heap.size("fb_batch_desc"));
  }

  /** Those of a module, made for the first of their users; each has to call `leave`. */
  static enter(heap: Heap): PoseRooms {
    let found = entered.get(heap);
    if (!found) entered.set(heap, (found = new PoseRooms(heap)));
    ++found.users;
    return found;
  }

  room(name: string): Room {
    let found = this.rooms.get(name);
    if (!found) this.rooms.set(name, (found = new Room(this.heap)));
    return found;
  }

  /** Frees them where this was the last of their users. */
  leave(): void {
    if (--this.users > 0) return;
    entered.delete(this.heap);
    for (const room of this.rooms.values()) room.release();
    this.heap.release(this.desc);
  }
}

const entered = new WeakMap<Heap, PoseRooms>();
