/** The three.js scene: light, air, and one or two views of it. */

import * as THREE from "three";

THREE.Object3D.DEFAULT_UP.set(0, 0, 1);

export const COLOURS = { air: 0xf4f5f3, goal: 0x299e5a, push: 0xd45c45, ink: 0x202630 };
/** Beyond these distances [m] the ground fades into the air. */
const FADE: [number, number] = [16, 46];
const SUN = new THREE.Vector3(2.4, -3.2, 6.5);
/** Half the side [m] of the square that shadows are drawn in. */
const SHADOWS = 5;

/** Frames that take longer than this [s] on average are too slow; so many frames pass between two measures. */
const [SLOW_FRAME, SETTLING] = [1 / 36, 40];
/** A frame that takes longer [s] by itself was not slow to draw: the page was hidden, or busy with loading. */
const PAUSE = 0.1;
const COARSEST = 0.5;

export interface View {
  camera: THREE.PerspectiveCamera;
  /** What the light follows. */
  middle: THREE.Vector3;
  /** Shown before this view is drawn, hidden after it. */
  own: THREE.Object3D[];
}

export class Stage {
  readonly scene = new THREE.Scene();
  readonly renderer: THREE.WebGLRenderer;
  /** Share of the canvas' pixels along each side that is drawn. */
  private sharpness = 1;
  private pace = 1 / 60;
  private settled = 0;
  private paused = false;
  private readonly sun = new THREE.DirectionalLight(0xfff8ee, 2.3);

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.setScissorTest(true);
    this.scene.background = new THREE.Color(COLOURS.air);
    this.scene.fog = new THREE.Fog(COLOURS.air, ...FADE);
    this.scene.add(new THREE.HemisphereLight(0xf3f7fb, 0xbdb9b0, 1.55));
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.radius = 5;
    this.sun.shadow.bias = -0.0006;
    this.sun.shadow.normalBias = 0.02;
    const box = this.sun.shadow.camera;
    [box.left, box.right, box.bottom, box.top, box.near, box.far] = [-SHADOWS, SHADOWS, -SHADOWS, SHADOWS, 1, 16];
    this.scene.add(this.sun, this.sun.target);
  }

  /** Draw with less where frames take too long: first fewer pixels, then no shadows. Never back: that would flicker. */
  ease(seconds: number): void {
    const after = this.paused;
    this.paused = seconds > PAUSE;
    if (this.paused && !after) return;
    this.pace += 0.05 * (seconds - this.pace);
    this.settled += 1;
    if (this.pace < SLOW_FRAME || this.settled < SETTLING) return;
    this.settled = 0;
    if (this.sharpness > COARSEST) this.sharpness *= 0.75;
    else this.sun.castShadow = false;
  }

  /** Fit the drawing to the canvas; true if its size changed. */
  resize(): boolean {
    const ratio = Math.min(window.devicePixelRatio, 2) * this.sharpness;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x === width && size.y === height && this.renderer.getPixelRatio() === ratio) return false;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.canvas.parentElement!.classList.toggle("stacked", isStacked(width, height)); // the captions follow
    return true;
  }

  /** Draw views side by side, or one above the other on a canvas that is higher than wide; `before` prepares each. */
  draw(views: View[], before: (view: View) => void): void {
    const { x: width, y: height } = this.renderer.getSize(new THREE.Vector2());
    const stacked = isStacked(width, height);
    for (const view of views) for (const object of view.own) object.visible = false;
    views.forEach((view, i) => {
      const [w, h] = stacked ? [width, height / views.length] : [width / views.length, height];
      const [x, y] = stacked ? [0, height - (i + 1) * h] : [i * w, 0];
      this.renderer.setViewport(x, y, w, h);
      this.renderer.setScissor(x, y, w, h);
      view.camera.aspect = w / h;
      view.camera.updateProjectionMatrix();
      this.sun.target.position.copy(view.middle);
      this.sun.position.copy(view.middle).add(SUN);
      for (const object of view.own) object.visible = true;
      before(view);
      this.renderer.render(this.scene, view.camera);
      for (const object of view.own) object.visible = false;
    });
  }
}

export function isStacked(width: number, height: number): boolean {
  return width < height;
}

/** Free what an object and those below it hold on the graphics card. */
export function dispose(object: THREE.Object3D): void {
  object.removeFromParent();
  object.traverse((part) => {
    if (!(part instanceof THREE.Mesh)) return;
    part.geometry.dispose();
    for (const material of [part.material].flat() as THREE.Material[]) {
      for (const value of Object.values(material)) if (value instanceof THREE.Texture) value.dispose();
      material.dispose();
    }
  });
}
