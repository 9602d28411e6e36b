/** A base and the adaptations that were loaded so far, in one ONNX graph. */

import * as ort from "onnxruntime-web/wasm";

import type { Listed } from "./site";

export type Load = (path: string) => Promise<Uint8Array<ArrayBuffer>>;

export function openRuntime(wasm: ArrayBuffer): void {
  ort.env.wasm.wasmBinary = wasm;
  ort.env.wasm.numThreads = 1;
  ort.env.logLevel = "error";
}

/** Acts for any number of characters at once, each at its own strengths. */
export class Policy {
  private session: ort.InferenceSession | null = null;
  private loaded: Listed[] = [];
  private readonly weights = new Map<string, Uint8Array>();
  private queue: Promise<unknown> = Promise.resolve();
  private running: Promise<unknown> = Promise.resolve();

  constructor(
    readonly base: string,
    readonly adaptations: Listed[],
    private readonly load: Load,
    private readonly mapSize: number,
  ) {}

  /** Whether some adaptation that acts reads a heightmap; `strengths` has one record for each character. */
  readsHeightmap(strengths: Record<string, number>[]): boolean {
    return this.loaded.some((part) => part.heightmap && strengths.some((row) => row[part.name]));
  }

  /** Whether the base is there. */
  get ready(): boolean {
    return this.session !== null;
  }

  has(name: string): boolean {
    return this.ready && this.loaded.some((part) => part.name === name);
  }

  /**
   * See that adaptations are loaded; others, which cost time at any strength, may go.
   *
   * The base comes with the first call, even if they cannot be had.
   */
  async add(names: string[]): Promise<void> {
    const work = this.queue.then(() =>
      this.addNow(names).catch(async (error) => {
        if (!this.ready) await this.addNow([]);
        throw error;
      }),
    );
    this.queue = work.catch(() => undefined);
    return work;
  }

  private async addNow(names: string[]): Promise<void> {
    if (this.session && names.every((name) => this.has(name))) return;
    const wanted = this.adaptations.filter((part) => names.includes(part.name));
    const parts = [...wanted.filter((part) => !part.heightmap), ...wanted.filter((part) => part.heightmap)];
    const maps = parts.filter((part) => part.heightmap).length;
    const [graph] = await Promise.all([
      this.load(`data/policies/${this.base}/graph-${parts.length - maps}-${maps}.onnx`),
      ...["base", ...parts.map((part) => part.name)].map((name) => this.fetchWeights(name)),
    ]);
    const slots = parts.map((part, i) => [part.heightmap ? `map${i - parts.length + maps}` : `flat${i}`, part.name]);
    const externalData = [["base", "base"], ...slots].map(([slot, name]) => ({
      path: `${slot}.bin`,
      data: this.weights.get(name)!,
    }));
    const session = await ort.InferenceSession.create(graph, { externalData, executionProviders: ["wasm"] });
    const old = this.session;
    [this.session, this.loaded] = [session, parts];
    await this.running;
    await old?.release();
  }

  private async fetchWeights(name: string): Promise<void> {
    if (!this.weights.has(name)) this.weights.set(name, await this.load(`data/policies/${this.base}/${name}.bin`));
  }

  /**
   * Actions of N characters, one row each.
   *
   * `strengths` has one record for each character; adaptations that are not loaded do not act. `heightmaps` may be
   * empty where `readsHeightmap` says so.
   */
  async act(
    observations: Float32Array,
    heightmaps: Float32Array,
    strengths: Record<string, number>[],
  ): Promise<Float32Array> {
    const [session, loaded, n] = [this.session, this.loaded, strengths.length];
    if (!session) throw new Error(`the policy ${this.base} is not loaded yet`);
    const feeds: Record<string, ort.Tensor> = {
      observation: new ort.Tensor("float32", observations, [n, observations.length / n]),
    };
    if (loaded.length > 0) {
      const rows = strengths.flatMap((row) => loaded.map((part) => row[part.name] ?? 0));
      feeds.strengths = new ort.Tensor("float32", Float32Array.from(rows), [n, loaded.length]);
    }
    if (loaded.some((part) => part.heightmap)) {
      const maps = heightmaps.length ? heightmaps : new Float32Array(n * this.mapSize ** 2);
      feeds.heightmap = new ort.Tensor("float32", maps, [n, 1, this.mapSize, this.mapSize]);
    }
    const answer = session.run(feeds);
    this.running = answer.catch(() => undefined);
    const { action } = await answer;
    const values = action.data as Float32Array;
    action.dispose();
    return values;
  }

  async close(): Promise<void> {
    await this.queue;
    await this.session?.release();
    this.session = null;
  }
}
