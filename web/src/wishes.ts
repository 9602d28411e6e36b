/** What a person asks for, and how a link says it. */

import type { Index, Listed, Specification } from "./site";

export const WEAKEST = -0.5;
export const STRONGEST = 1.5;
/** Preferred speeds that can be asked for, as factors on the ends of the range that the base learned. */
const SPEED_REACH: [number, number] = [0.5, 1.25];
export const PUSHES: [number, number] = [50, 1000];
export const SLOW = 0.25;
const USUAL_PUSH = 200;

export interface Wishes {
  base: string;
  body: string;
  lock: string;
  ground: string;
  strengths: Record<string, number>;
  /** World direction [rad]; null for the one in which the scene starts. */
  heading: number | null;
  /** [m/s] */
  speed: number;
  /** [N] */
  force: number;
  /** Whether the base is shown beside the adapted character. */
  compare: boolean;
  slow: boolean;
}

export function speedsOf(base: string, specification: Specification): [number, number] {
  const [low, high] = specification.bases[base].speeds;
  return [SPEED_REACH[0] * low, SPEED_REACH[1] * high];
}

export function clipped(value: number, [low, high]: [number, number]): number {
  return Math.min(Math.max(value, low), high);
}

/** What a link's part behind the # asks for; whatever it leaves out, or says wrongly, is as usual. */
export function wishesOf(hash: string, index: Index, specification: Specification): Wishes {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const base = oneOf(given.get("base"), index.bases, "walk");
  const strengths: Record<string, number> = {};
  for (const { name } of index.bases[base]) {
    const strength = numberOf(given.get(name), [WEAKEST, STRONGEST], 0);
    if (strength !== 0) strengths[name] = strength;
  }
  return {
    base,
    body: oneOf(given.get("body"), index.bodies, "plain"),
    lock: oneOf(given.get("lock"), index.locks, "plain"),
    ground: oneOf(given.get("ground"), index.grounds, "flat"),
    strengths,
    heading: given.has("heading") ? numberOf(given.get("heading"), [-Math.PI, Math.PI], 0) : null,
    speed: numberOf(given.get("speed"), speedsOf(base, specification), usualSpeed(base, strengths, index, specification)),
    force: numberOf(given.get("force"), PUSHES, USUAL_PUSH),
    compare: given.has("compare"),
    slow: given.has("slow"),
  };
}

/** The link's part that `wishesOf` reads back. */
export function hashOf(wishes: Wishes): string {
  const { base, body, lock, ground, strengths, heading, speed, force, compare, slow } = wishes;
  const parts: [string, string][] = [["base", base]];
  for (const [name, value] of Object.entries({ body, lock })) if (value !== "plain") parts.push([name, value]);
  if (ground !== "flat") parts.push(["ground", ground]);
  for (const [name, strength] of Object.entries(strengths)) if (strength !== 0) parts.push([name, round(strength)]);
  parts.push(["speed", round(speed)]);
  if (heading !== null) parts.push(["heading", round(heading)]);
  if (force !== USUAL_PUSH) parts.push(["force", round(force)]);
  const flags = [compare ? "&compare" : "", slow ? "&slow" : ""];
  return `#${parts.map((part) => part.join("=")).join("&")}${flags.join("")}`;
}

/** The middle of the speeds that the strongest adaptation learned, or the base. */
function usualSpeed(base: string, strengths: Record<string, number>, index: Index, specification: Specification): number {
  const strongest = index.bases[base].reduce<Listed | null>((best, part) => {
    return (strengths[part.name] ?? 0) > (best ? strengths[best.name] : 0.25) ? part : best;
  }, null);
  const [low, high] = strongest?.speeds ?? specification.bases[base].speeds;
  return (low + high) / 2;
}

function oneOf(given: string | null, table: object, usual: string): string {
  return given !== null && Object.hasOwn(table, given) ? given : usual;
}

function numberOf(given: string | null, range: [number, number], usual: number): number {
  const value = given === null || given.trim() === "" ? NaN : Number(given);
  return Number.isFinite(value) ? clipped(value, range) : usual;
}

function round(value: number): string {
  return String(Math.round(value * 100) / 100);
}
