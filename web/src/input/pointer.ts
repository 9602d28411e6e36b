/** The mouse and fingers on the picture: drag it to look around, pull the character to push it. */

import * as THREE from "three";

import type { Angles } from "../view/orbit";
import { clipped, PUSHES } from "../wishes";

/** Newtons for each metre that the character is pulled, and how far [pixels] a pointer moves before it pulls. */
const [PULL, STILL] = [350, 6];
/** Half a character's height, and how far from its axis it can be grasped [m]. */
const [HALF_HEIGHT, NEAR] = [0.75, 0.28];
const [TURN, TILT, ZOOM] = [0.006, 0.004, 0.0012];
const DISTANCES: [number, number] = [2.2, 14];
const ELEVATIONS: [number, number] = [-0.05, 1.2];

export interface Target {
  camera: THREE.PerspectiveCamera;
  /** The pelvis. */
  middle: THREE.Vector3;
  /** The view's corner and size in the canvas, each in [0, 1]; y downwards. */
  box: { x: number; y: number; w: number; h: number };
}

/** A pull that has begun: the level plane through the place that was grasped, and where a pointer is on it. */
interface Pull {
  target: Target;
  level: THREE.Plane;
  from: THREE.Vector3;
  event: PointerEvent;
}

export class Pointer {
  private readonly active = new Map<number, PointerEvent>();
  private pulled: Pull | null = null;
  private readonly caster = new THREE.Raycaster();

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly angles: Angles,
    private readonly targets: () => Target[],
    private readonly push: (x: number, y: number) => void,
  ) {
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", (event) => this.end(event));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  private down(event: PointerEvent): void {
    this.active.set(event.pointerId, event);
    const first = this.active.size === 1;
    this.pulled = first ? this.grasp(event) : null;
    this.canvas.classList.toggle("pulling", this.pulled !== null);
    this.canvas.setPointerCapture(event.pointerId);
  }

  /** Grasp the character that a pointer is on, or nearly: limbs that move are hard to hit. */
  private grasp(event: PointerEvent): Pull | null {
    for (const target of this.targets()) {
      const [feet, head] = [-1, 1].map((side) => target.middle.clone().setZ(target.middle.z + side * HALF_HEIGHT));
      const from = new THREE.Vector3();
      if (!this.aim(event, target)) continue;
      if (this.caster.ray.distanceSqToSegment(feet, head, undefined, from) >= NEAR ** 2) continue;
      const level = new THREE.Plane(new THREE.Vector3(0, 0, 1), -from.z);
      return { target, level, from: this.caster.ray.intersectPlane(level, new THREE.Vector3()) ?? from, event };
    }
    return null;
  }

  /** Aim the ray at a pointer's place; false if it is outside the target's view. */
  private aim(event: PointerEvent, { camera, box }: Target): boolean {
    const frame = this.canvas.getBoundingClientRect();
    const x = ((event.clientX - frame.left) / frame.width - box.x) / box.w;
    const y = ((event.clientY - frame.top) / frame.height - box.y) / box.h;
    this.caster.setFromCamera(new THREE.Vector2(2 * x - 1, 1 - 2 * y), camera);
    return x >= 0 && x <= 1 && y >= 0 && y <= 1;
  }

  private move(event: PointerEvent): void {
    const before = this.active.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
    if (this.active.size === 2) this.pinch(event, before);
    else if (!this.pulled) {
      this.angles.azimuth -= TURN * dx;
      this.angles.elevation = clipped(this.angles.elevation + TILT * dy, ELEVATIONS);
    } else return; // where the pull began counts
    this.active.set(event.pointerId, event);
  }

  private pinch(event: PointerEvent, before: PointerEvent): void {
    const other = [...this.active.values()].find((found) => found.pointerId !== event.pointerId)!;
    const gap = (from: PointerEvent) => Math.hypot(from.clientX - other.clientX, from.clientY - other.clientY);
    this.angles.distance = clipped((this.angles.distance * gap(before)) / Math.max(gap(event), 1), DISTANCES);
  }

  private up(event: PointerEvent): void {
    const pulled = this.pulled;
    this.end(event);
    if (!pulled) return;
    const { target, level, from, event: begun } = pulled;
    if (Math.hypot(event.clientX - begun.clientX, event.clientY - begun.clientY) < STILL) return;
    this.aim(event, target);
    const to = this.caster.ray.intersectPlane(level, new THREE.Vector3());
    // Above the horizon no place is meant, but a direction.
    const pull = (to ? to.sub(from) : this.caster.ray.direction.clone()).setZ(0);
    const force = to ? clipped(PULL * pull.length(), PUSHES) : PUSHES[1];
    pull.normalize().multiplyScalar(force);
    this.push(pull.x, pull.y);
  }

  private end(event: PointerEvent): void {
    this.active.delete(event.pointerId);
    this.pulled = null;
    this.canvas.classList.remove("pulling");
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.angles.distance = clipped(this.angles.distance * Math.exp(ZOOM * event.deltaY), DISTANCES);
  }
}
