import { defineConfig } from "vitest/config";

export default defineConfig({
  test: { include: ["test/**/*.test.ts"], testTimeout: 900_000, hookTimeout: 240_000, fileParallelism: false },
});
