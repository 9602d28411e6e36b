// Compressed copies of the libraries' WebAssembly for the page, which unpacks them whatever the web server can do.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const files = {
  mujoco: "node_modules/@mujoco/mujoco/mujoco.wasm",
  onnxruntime: "node_modules/onnxruntime-web/dist/ort-wasm-simd-threaded.wasm",
};
mkdirSync("public/wasm", { recursive: true });
for (const [name, file] of Object.entries(files)) {
  writeFileSync(`public/wasm/${name}.wasm.gz`, gzipSync(readFileSync(file), { level: 9 }));
}
