/** A camera that follows a character; its place is given by angles and a distance that a person can change. */

import * as THREE from "three";

import { wrapped } from "../rotations";

/** Per second: how fast the camera catches up with the character, and with where it goes. */
const [FOLLOW, TURN] = [7, 0.9];
const LOOK_HEIGHT = 0.82;

export interface Angles {
  /** Around the character from its heading [rad], counter-clockwise; 0 looks at its face. */
  azimuth: number;
  /** Above the horizon [rad]. */
  elevation: number;
  distance: number;
}

export class Orbit {
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.1, 120);
  readonly middle = new THREE.Vector3();
  private heading: number | null = null;

  constructor(readonly angles: Angles) {}

  /** Follow a character at `at` [m] that goes in the direction `heading` [rad]; `floor` is the ground's height there. */
  follow(at: THREE.Vector3, floor: number, heading: number, seconds: number): void {
    const wanted = new THREE.Vector3(at.x, at.y, floor + Math.max(LOOK_HEIGHT, 0.9 * (at.z - floor)));
    const far = this.heading === null || wanted.distanceTo(this.middle) > 4;
    this.middle.lerp(wanted, far ? 1 : 1 - Math.exp(-FOLLOW * seconds));
    const turn = wrapped(heading - (this.heading ?? heading));
    this.heading = (this.heading ?? heading) + (far ? turn : turn * (1 - Math.exp(-TURN * seconds)));
    const { azimuth, elevation, distance } = this.angles;
    const around = this.heading + azimuth;
    const reach = distance * (this.camera.aspect < 0.8 ? 1.25 : 1);
    const flat = reach * Math.cos(elevation);
    this.camera.position.set(
      this.middle.x + flat * Math.cos(around),
      this.middle.y + flat * Math.sin(around),
      this.middle.z + reach * Math.sin(elevation),
    );
    this.camera.lookAt(this.middle);
  }

  /** Direction on the ground [rad] in which the camera looks. */
  get direction(): number {
    const { x, y } = this.camera.position;
    return Math.atan2(this.middle.y - y, this.middle.x - x);
  }
}
