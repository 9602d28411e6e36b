/** A character as its model describes it: a group for each body with the shapes of its geoms. */

import * as THREE from "three";

import type { Body, Motion } from "../physics";

const SPHERE = 2;
const CAPSULE = 3;
const BOX = 6;

export class Figure {
  readonly group = new THREE.Group();
  private readonly bodies: THREE.Group[] = [];
  readonly middle = new THREE.Vector3();

  /** `faded` figures are paler: the base beside the adapted character. */
  constructor(
    readonly body: Body,
    faded: boolean,
  ) {
    const { model } = body;
    for (let i = 1; i < model.nbody; i++) {
      const part = new THREE.Group();
      const first = model.body_geomadr[i];
      for (let geom = first; geom < first + model.body_geomnum[i]; geom++) {
        const mesh = meshOf(body, geom, faded);
        if (mesh) part.add(mesh);
      }
      this.bodies.push(part);
      this.group.add(part);
    }
  }

  /** Put the bodies where they are now. */
  place(motion: Motion): void {
    const { xpos, xquat } = motion.data;
    this.bodies.forEach((part, i) => {
      const [p, q] = [3 * (i + 1), 4 * (i + 1)];
      part.position.set(xpos[p], xpos[p + 1], xpos[p + 2]);
      part.quaternion.set(xquat[q + 1], xquat[q + 2], xquat[q + 3], xquat[q]);
    });
    this.middle.copy(this.bodies[0].position);
  }
}

function meshOf(body: Body, geom: number, faded: boolean): THREE.Mesh | null {
  const { model } = body;
  const shape = shapeOf(model.geom_type[geom], model.geom_size.subarray(3 * geom, 3 * geom + 3));
  if (!shape) return null;
  const mesh = new THREE.Mesh(shape, new THREE.MeshStandardMaterial({ color: colourOf(body, geom, faded) }));
  const material = mesh.material as THREE.MeshStandardMaterial;
  [material.roughness, material.metalness] = [0.62, 0];
  const [p, q] = [3 * geom, 4 * geom];
  mesh.position.set(model.geom_pos[p], model.geom_pos[p + 1], model.geom_pos[p + 2]);
  mesh.quaternion.set(model.geom_quat[q + 1], model.geom_quat[q + 2], model.geom_quat[q + 3], model.geom_quat[q]);
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}

function shapeOf(kind: number, size: Float64Array): THREE.BufferGeometry | null {
  if (kind === SPHERE) return new THREE.SphereGeometry(size[0], 28, 20);
  if (kind === CAPSULE) return new THREE.CapsuleGeometry(size[0], 2 * size[1], 10, 24).rotateX(Math.PI / 2);
  if (kind === BOX) return new THREE.BoxGeometry(2 * size[0], 2 * size[1], 2 * size[2]);
  return null;
}

function colourOf({ model }: Body, geom: number, faded: boolean): THREE.Color {
  const material = model.geom_matid[geom];
  const [table, at] = material < 0 ? [model.geom_rgba, 4 * geom] : [model.mat_rgba, 4 * material];
  const colour = new THREE.Color().setRGB(table[at], table[at + 1], table[at + 2], THREE.SRGBColorSpace);
  if (!faded) return colour;
  const grey = 0.3 * colour.r + 0.59 * colour.g + 0.11 * colour.b;
  return colour.lerp(new THREE.Color(grey, grey, grey), 0.75).lerp(new THREE.Color(0xffffff), 0.12);
}
