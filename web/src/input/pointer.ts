/** The mouse and fingers on the picture: drag it to look around, pull the character to push it. */

import * as THREE from "three";

import type { Angles } from "../view/orbit";
import { clipped, PUSHES } from "../wishes";

/** Newtons for each metre that the character is pulled. */
const PULL = 350;
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

export class Pointer {
  private readonly active = new Map<number, PointerEvent>();
  private pulled: Target | null = null;
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
    this.pulled = first ? (this.targets().find((target) => this.hits(event, target)) ?? null) : null;
    this.canvas.classList.toggle("pulling", this.pulled !== null);
    this.canvas.setPointerCapture(event.pointerId);
  }

  /** Whether a pointer is on a character, or nearly: limbs that move are hard to hit. */
  private hits(event: PointerEvent, target: Target): boolean {
    const [feet, head] = [-1, 1].map((side) => target.middle.clone().setZ(target.middle.z + side * HALF_HEIGHT));
    return this.aim(event, target) && this.caster.ray.distanceSqToSegment(feet, head) < NEAR ** 2;
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
    const target = this.pulled;
    this.end(event);
    if (!target) return;
    this.aim(event, target);
    const level = new THREE.Plane(new THREE.Vector3(0, 0, 1), -target.middle.z);
    const point = this.caster.ray.intersectPlane(level, new THREE.Vector3());
    const pull = (point ?? target.camera.position.clone()).sub(target.middle).setZ(0);
    const force = clipped(PULL * pull.length(), PUSHES);
    pull.normalize().multiplyScalar(point ? force : -force);
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
