// Quantised coefficients of poses as digit_sums_shader.ts reads them. Octets are eight poses; of each, only quads of
// columns in which some pose has a number that is not 0 are listed.
import { posesOfOctet } from "./digit_sums_shader.js";
import { quadCount } from "./packed_digits.js";
import type { QuantisedOutputs } from "./quantised_poses.js";
import type { RowBlock } from "./row_blocks.js";

/** Words of a listed quad in `factors`: of each pose four low bytes, then of each pose four high ones. */
export const factorWords = 2 * posesOfOctet;

export interface GpuFactors {
  readonly octets: number;
  readonly lists: Uint32Array;
  readonly factors: Uint32Array;
  /** Where in `lists` quads begin. */
  readonly quads: number;
}

export class FactorPacker {
  /** Quads of all row blocks: the most that an octet lists. */
  readonly quadCount: number;
  private readonly columnCount: number;
  private readonly quadOfColumn: Uint32Array;
  private readonly firstColumn: readonly number[]; // by row block, and one more
  private readonly used: Uint8Array;               // by quad: in this octet
  private lists = new Uint32Array(0);
  private factors = new Uint32Array(0);

  constructor(blocks: readonly RowBlock[], private readonly exactCount: number) {
    const firstColumn = [0], quads: number[] = [];
    let quad = 0;
    for (const block of blocks) {
      block.columns.forEach((_, column) => quads.push(quad + (column >> 2)));
      quad += quadCount(block);
      firstColumn.push(quads.length);
    }
    this.quadCount = quad;
    this.columnCount = quads.length;
    this.quadOfColumn = Uint32Array.from(quads);
    this.firstColumn = firstColumn;
    this.used = new Uint8Array(quad);
  }

  /** The most bytes that either array takes for so many octets. */
  mostBytes(octets: number): number {
    const perBlock = (1 + posesOfOctet) * (this.firstColumn.length - 1), exact = posesOfOctet * this.exactCount;
    return 4 * octets * Math.max(factorWords * this.quadCount, perBlock + exact + this.quadCount) + 4;
  }

  /** `quantised`, `steps` and `exactWeights` of poses one after the other. What is returned holds until the next call. */
  pack({ quantised, steps, exactWeights }: Required<Omit<QuantisedOutputs, "joints">>, poses: number): GpuFactors {
    const octets = Math.ceil(poses / posesOfOctet), blocks = this.firstColumn.length - 1;
    const stepsAt = octets * blocks + 1, weightsAt = stepsAt + octets * blocks * posesOfOctet;
    const quads = weightsAt + octets * this.exactCount * posesOfOctet;
    this.reserve(quads + octets * this.quadCount, octets * this.quadCount * factorWords);
    const { lists } = this;
    spread(steps, blocks, poses, lists, stepsAt);
    spread(exactWeights, this.exactCount, poses, lists, weightsAt);
    lists[0] = 0;
    let listed = 0;
    for (let octet = 0; octet < octets; ++octet) {
      const first = octet * posesOfOctet, count = Math.min(posesOfOctet, poses - first);
      this.findUsed(quantised, first, count);
      for (let block = 0; block < blocks; ++block) {
        listed = this.packBlock(quantised, first, count, block, quads, listed);
        lists[octet * blocks + block + 1] = listed;
      }
    }
    return { octets, quads, lists: lists.subarray(0, quads + listed), factors: this.factors.subarray(0, listed * factorWords) };
  }

  private reserve(lists: number, factors: number): void {
    if (this.lists.length < lists) this.lists = new Uint32Array(lists);
    if (this.factors.length < factors) this.factors = new Uint32Array(factors);
  }

  private findUsed(quantised: Int16Array, first: number, count: number): void {
    const { columnCount, quadOfColumn, used } = this;
    used.fill(0);
    for (let pose = first; pose < first + count; ++pose)
      for (let column = 0, at = pose * columnCount; column < columnCount; ++column, ++at)
        if (quantised[at] !== 0) used[quadOfColumn[column]!] = 1;
  }

  /** Returns how many quads are listed with those of the block. */
  private packBlock(quantised: Int16Array, first: number, count: number, block: number, quads: number,
                    listed: number): number {
    const { columnCount, lists, factors } = this, begin = this.firstColumn[block]!, end = this.firstColumn[block + 1]!;
    for (let column = begin, quad = 0; column < end; column += 4, ++quad) {
      if (!this.used[this.quadOfColumn[column]!]) continue;
      lists[quads + listed] = quad;
      const words = listed++ * factorWords, columns = Math.min(4, end - column);
      for (let pose = 0; pose < posesOfOctet; ++pose) {
        let low = 0, high = 0;
        for (let k = 0, at = (first + pose) * columnCount + column; pose < count && k < columns; ++k, ++at) {
          const value = quantised[at]!;
          low |= (value & 255) << (8 * k);
          high |= (((value + 128) >> 8) & 255) << (8 * k);
        }
        factors[words + pose] = low;
        factors[words + posesOfOctet + pose] = high;
      }
    }
    return listed;
  }
}

// The bits of `size` floats a pose: those of an octet's poses beside each other, 0 for poses that it has not.
function spread(floats: Float32Array, size: number, poses: number, to: Uint32Array, at: number): void {
  const bits = new Uint32Array(floats.buffer, floats.byteOffset, floats.length);
  for (let pose = 0, whole = Math.ceil(poses / posesOfOctet) * posesOfOctet; pose < whole; ++pose)
    for (let i = 0, octet = Math.floor(pose / posesOfOctet); i < size; ++i)
      to[at + (octet * size + i) * posesOfOctet + (pose % posesOfOctet)] = pose < poses ? bits[pose * size + i]! : 0;
}
