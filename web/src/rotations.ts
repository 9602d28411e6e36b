/** Unit quaternions w, x, y, z and headings, as in adapt_envs.features.rotations. */

export type Numbers = ArrayLike<number>;

/** Heading [rad] of a root's orientation, which begins at `at` in `values`: the direction of its x axis on the ground. */
export function headingOf(values: Numbers, at = 0): number {
  const [w, x, y, z] = [values[at], values[at + 1], values[at + 2], values[at + 3]];
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

/** An angle [rad] brought into [-pi, pi). */
export function wrapped(angle: number): number {
  const turn = 2 * Math.PI;
  return ((((angle + Math.PI) % turn) + turn) % turn) - Math.PI;
}

/** Turn the vector that begins at `at` about z. */
export function turnVector(values: Float32Array | Float64Array, at: number, angle: number): void {
  const [c, s, x, y] = [Math.cos(angle), Math.sin(angle), values[at], values[at + 1]];
  values[at] = c * x - s * y;
  values[at + 1] = s * x + c * y;
}

/** Turn the orientation that begins at `at` about z. */
export function turnQuaternion(values: Float32Array | Float64Array, at: number, angle: number): void {
  const [c, s] = [Math.cos(angle / 2), Math.sin(angle / 2)];
  const [w, x, y, z] = [values[at], values[at + 1], values[at + 2], values[at + 3]];
  values[at] = c * w - s * z;
  values[at + 1] = c * x - s * y;
  values[at + 2] = c * y + s * x;
  values[at + 3] = c * z + s * w;
}
