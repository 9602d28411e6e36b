/** The ground as one sees it: endless and flat, or as high as it is, with its blocks. */

import * as THREE from "three";

import type { Ground } from "../ground";

/** Side of the flat ground that moves along [m]; a whole number of its squares. */
const SIDE = 120;
/** Every how manyth height of uneven ground is drawn. */
const EVERY = 2;
const PIXELS = 256;
const TINTS = { ground: "#e4e5e2", line: "#d0d2cf", ice: "#dcebf5", iceLine: "#c3dcec" };
const BLOCK = 0xc4a78d;
/** Colours of heights from valleys to tops, at shares of their range. */
const RELIEF: [number, number][] = [
  [0, 0x93a9a8],
  [0.3, 0xb8c4bb],
  [0.5, 0xd9d8c8],
  [0.75, 0xe8ddc4],
  [1, 0xf6ecd8],
];

export class Landscape {
  readonly group = new THREE.Group();
  private readonly flat: THREE.Mesh | null = null;

  constructor(readonly ground: Ground) {
    const icy = ground.file.friction < 0.5;
    if (ground.shares) this.group.add(relief(ground));
    else this.group.add((this.flat = plain(icy)));
    if (ground.file.blocks) this.group.add(blocks(ground.file.blocks));
  }

  /** Keep flat ground around a point. */
  follow(x: number, y: number): void {
    this.flat?.position.set(2 * Math.round(x / 2), 2 * Math.round(y / 2), 0);
  }
}

function plain(icy: boolean): THREE.Mesh {
  const map = squares(icy ? TINTS.ice : TINTS.ground, icy ? TINTS.iceLine : TINTS.line);
  map.repeat.set(SIDE / 2, SIDE / 2);
  const material = new THREE.MeshStandardMaterial({ map, roughness: icy ? 0.25 : 0.95, metalness: icy ? 0.08 : 0 });
  const mesh = new THREE.Mesh(new THREE.PlaneGeometry(SIDE, SIDE), material);
  mesh.receiveShadow = true;
  return mesh;
}

/** A picture of four squares of 1 m, two of them a little darker, with fine lines. */
function squares(paper: string, line: string): THREE.CanvasTexture {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 2 * PIXELS;
  const pen = canvas.getContext("2d")!;
  pen.fillStyle = paper;
  pen.fillRect(0, 0, 2 * PIXELS, 2 * PIXELS);
  pen.fillStyle = "rgba(32, 38, 48, 0.022)";
  pen.fillRect(0, 0, PIXELS, PIXELS);
  pen.fillRect(PIXELS, PIXELS, PIXELS, PIXELS);
  pen.strokeStyle = line;
  pen.lineWidth = 3;
  for (const at of [0, PIXELS, 2 * PIXELS]) {
    pen.strokeRect(at, -9, 0, 2 * PIXELS + 18);
    pen.strokeRect(-9, at, 2 * PIXELS + 18, 0);
  }
  const texture = new THREE.CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.anisotropy = 8;
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

function relief(ground: Ground): THREE.Mesh {
  const { rows, columns, grid, low, lowest, highest } = ground.file.surface!;
  const [high, wide] = [Math.floor((rows - 1) / EVERY) + 1, Math.floor((columns - 1) / EVERY) + 1];
  const shape = new THREE.PlaneGeometry(1, 1, wide - 1, high - 1);
  const [place, uv] = [shape.attributes.position, shape.attributes.uv];
  const tints = new Float32Array(3 * place.count);
  for (let i = 0; i < place.count; i++) {
    const [row, column] = [EVERY * Math.floor(i / wide), EVERY * (i % wide)];
    const share = ground.shares![row * columns + column];
    const [x, y] = [low[0] + grid * column, low[1] + grid * row];
    place.setXYZ(i, x, y, lowest + share * (highest - lowest));
    uv.setXY(i, x / 2, y / 2);
    tintOf(share).toArray(tints, 3 * i);
  }
  shape.setAttribute("color", new THREE.BufferAttribute(tints, 3));
  shape.index!.array.reverse(); // rows now go along y, which turns the triangles over
  shape.computeVertexNormals();
  const map = squares("#ffffff", "#eeeeea");
  const mesh = new THREE.Mesh(shape, new THREE.MeshStandardMaterial({ map, vertexColors: true, roughness: 0.95 }));
  mesh.receiveShadow = true;
  return mesh;
}

function tintOf(share: number): THREE.Color {
  const above = Math.max(1, RELIEF.findIndex(([height]) => share <= height));
  const [[low, from], [high, to]] = [RELIEF[above - 1], RELIEF[above]];
  return new THREE.Color(from).lerp(new THREE.Color(to), (share - low) / (high - low));
}

function blocks(file: NonNullable<Ground["file"]["blocks"]>): THREE.InstancedMesh {
  const material = new THREE.MeshStandardMaterial({ color: BLOCK, roughness: 0.8 });
  const mesh = new THREE.InstancedMesh(new THREE.BoxGeometry(2, 2, 1), material, file.x.length);
  const [turn, up] = [new THREE.Quaternion(), new THREE.Vector3(0, 0, 1)];
  file.x.forEach((x, i) => {
    const place = new THREE.Vector3(x, file.y[i], file.top[i] / 2);
    const size = new THREE.Vector3(file.half_x[i], file.half_y[i], file.top[i]);
    mesh.setMatrixAt(i, new THREE.Matrix4().compose(place, turn.setFromAxisAngle(up, file.yaw[i]), size));
  });
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}
