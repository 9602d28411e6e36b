/** What is wished for and what happens, drawn beside a character: where to go, and pushes. */

import * as THREE from "three";

import type { Ground } from "../ground";
import type { Walker } from "../walker";
import { COLOURS } from "./stage";

/** Nearest and farthest end of the arrow to the goal [m]; half a metre for each metre per second. */
const [FROM, LENGTH] = [0.5, 0.5];
/** Length [m] of a push of 1000 N. */
const PUSH_LENGTH = 2.2;

export class Signs {
  readonly group = new THREE.Group();
  private readonly goal = flatArrow(COLOURS.goal);
  private readonly push = new THREE.ArrowHelper(
    new THREE.Vector3(1, 0, 0),
    new THREE.Vector3(),
    1,
    COLOURS.push,
    0.16,
    0.12,
  );

  constructor(private readonly ground: Ground) {
    this.group.add(this.goal, this.push);
  }

  place(walker: Walker, heading: number, speed: number): void {
    const [x, y] = walker.rootXY;
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    const middle = FROM + (LENGTH * speed) / 2;
    const height = this.ground.floorAt(x + c * middle, y + s * middle);
    this.goal.position.set(x + c * FROM, y + s * FROM, height + 0.02);
    this.goal.rotation.z = heading;
    this.goal.scale.set(LENGTH * speed, 1, 1);
    this.placePush(walker);
  }

  private placePush(walker: Walker): void {
    const size = Math.hypot(...walker.force);
    this.push.visible = size > 0;
    if (size === 0) return;
    const direction = new THREE.Vector3(walker.force[0] / size, walker.force[1] / size, 0);
    const at = 3 * walker.body.torso;
    const torso = new THREE.Vector3(...(walker.motion.data.xpos as Float64Array).subarray(at, at + 3));
    const length = (PUSH_LENGTH * size) / 1000;
    torso.z += 0.12;
    this.push.position.copy(torso.addScaledVector(direction, -length - 0.1));
    this.push.setDirection(direction);
    this.push.setLength(length, 0.16, 0.12);
  }
}

/** An arrow of length 1 along x that lies on the ground. */
function flatArrow(colour: number): THREE.Mesh {
  const outline = new THREE.Shape();
  outline.moveTo(0, 0.035);
  for (const [x, y] of [[0.72, 0.035], [0.72, 0.1], [1, 0], [0.72, -0.1], [0.72, -0.035], [0, -0.035]]) {
    outline.lineTo(x, y);
  }
  const material = new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.85, depthWrite: false });
  const mesh = new THREE.Mesh(new THREE.ShapeGeometry(outline), material);
  return mesh;
}
