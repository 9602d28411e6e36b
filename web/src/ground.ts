/** What characters stand on: its heights, and the heightmap that some policies read. */

import type { GroundFile, Specification } from "./site";

export class Ground {
  readonly reach: number;

  /** `shares` are the heights of uneven ground as shares of their range, rows along y. */
  constructor(
    readonly file: GroundFile,
    readonly shares: Float32Array | null,
  ) {
    this.reach = file.reach ?? Infinity;
  }

  get endless(): boolean {
    return this.file.reach === null;
  }

  /** Height [m] of the ground without its blocks, triangulated as MuJoCo does. */
  floorAt(x: number, y: number): number {
    const surface = this.file.surface;
    if (!surface || !this.shares) return 0;
    const { rows, columns, grid, low, lowest, highest } = surface;
    const u = Math.min(Math.max((x - low[0]) / grid, 0), columns - 1.001);
    const v = Math.min(Math.max((y - low[1]) / grid, 0), rows - 1.001);
    const [column, row] = [Math.floor(u), Math.floor(v)];
    const first = row * columns + column;
    const [along, across] = [u - column, v - row];
    const a = this.shares[first];
    const b = this.shares[first + (along > across ? 1 : columns)];
    const c = this.shares[first + columns + 1];
    const share = a + (b - a) * Math.max(along, across) + (c - b) * Math.min(along, across);
    return lowest + share * (highest - lowest);
  }

  /** Height [m] of the ground with its blocks. */
  heightAt(x: number, y: number): number {
    const floor = this.floorAt(x, y);
    const blocks = this.file.blocks;
    if (!blocks) return floor;
    let height = floor;
    for (let i = 0; i < blocks.x.length; i++) {
      const [dx, dy] = [x - blocks.x[i], y - blocks.y[i]];
      if (dx * dx + dy * dy > 2) continue; // the largest block's corner is 1.13 m from its middle
      const [c, s] = [Math.cos(blocks.yaw[i]), Math.sin(blocks.yaw[i])];
      const inside = Math.abs(c * dx + s * dy) <= blocks.half_x[i] && Math.abs(c * dy - s * dx) <= blocks.half_y[i];
      if (inside) height = Math.max(height, blocks.top[i]);
    }
    return height;
  }

  /** Write the heights around a root that faces `heading`, relative to the ground under it. */
  writeHeightmap(out: Float32Array, x: number, y: number, heading: number, map: Specification["heightmap"]): void {
    if (this.endless) return void out.fill(0);
    const [c, s, floor] = [Math.cos(heading), Math.sin(heading), this.floorAt(x, y)];
    for (let i = 0; i < map.size; i++) {
      const ahead = map.ahead - map.grid * i;
      for (let j = 0; j < map.size; j++) {
        const left = map.aside - map.grid * j;
        out[i * map.size + j] = this.heightAt(x + c * ahead - s * left, y + s * ahead + c * left) - floor;
      }
    }
  }

  /** A target that keeps its distance from the edge of bounded ground. */
  inside(target: [number, number], edge: number): [number, number] {
    const most = this.reach - edge;
    return [Math.min(Math.max(target[0], -most), most), Math.min(Math.max(target[1], -most), most)];
  }
}
