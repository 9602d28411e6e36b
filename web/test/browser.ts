/** A real browser on the built site. */

import { existsSync, mkdirSync } from "node:fs";

import puppeteer, { type Browser, type Page } from "puppeteer-core";
import { preview, type PreviewServer } from "vite";

const KNOWN = [
  process.env.CHROMIUM ?? "",
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
  "/usr/bin/google-chrome-stable",
  "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
];
export const CHROMIUM = KNOWN.find((file) => file && existsSync(file)) ?? null;
export const PICTURES = new URL("pictures/", import.meta.url).pathname;

export interface Site {
  browser: Browser;
  address: string;
  /** Close all pages, also those of a test that failed. */
  closePages(): Promise<void>;
  close(): Promise<void>;
}

export async function openSite(): Promise<Site> {
  mkdirSync(PICTURES, { recursive: true });
  const root = new URL("..", import.meta.url).pathname;
  const server: PreviewServer = await preview({ root, preview: { port: 0, host: "127.0.0.1" }, logLevel: "warn" });
  const address = server.resolvedUrls!.local[0];
  const browser = await puppeteer.launch({
    executablePath: CHROMIUM!,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--enable-precise-memory-info"],
    protocolTimeout: 300_000,
  });
  const closePages = async () => {
    const [first, ...pages] = await browser.pages();
    await Promise.all([first.goto("about:blank"), ...pages.map((page) => page.close())]);
  };
  const close = async () => {
    await browser.close();
    await server.close();
  };
  return { browser, address, closePages, close };
}

export const DESKTOP = { width: 1280, height: 800 };
/** A coarse picture, which the processor draws faster: for tests that look at none. */
export const COARSE = { width: 1000, height: 640, deviceScaleFactor: 0.3 };
export const PHONE = { width: 390, height: 844, isMobile: true, hasTouch: true, deviceScaleFactor: 2 };

export interface Visit {
  page: Page;
  /** What the page wrote to its console as errors or warnings, and what it threw. */
  complaints: string[];
  /** Addresses of other origins that it asked for. */
  elsewhere: string[];
  /** Bytes that came over the network. */
  bytes: () => number;
}

/** Open the page at a link's part and wait until it runs. */
export async function visit(site: Site, hash: string, size: object = COARSE): Promise<Visit> {
  const page = await site.browser.newPage();
  await page.setViewport(size as typeof DESKTOP);
  const [complaints, elsewhere]: [string[], string[]] = [[], []];
  let bytes = 0;
  page.on("console", (message) => {
    // The drawing in software warns of its own slowness when a picture is taken.
    if (["error", "warn"].includes(message.type()) && !message.text().includes("GPU stall")) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith(site.address) && !/^(data|blob):/.test(url)) elsewhere.push(url);
  });
  const client = await page.createCDPSession();
  await client.send("Network.enable");
  client.on("Network.loadingFinished", (event) => (bytes += event.encodedDataLength));
  await page.goto(`${site.address}${hash}`, { timeout: 120_000 });
  await page.waitForFunction("window.playground?.theatre && window.playground.frames > 2", { timeout: 120_000 });
  if (size === COARSE) await page.evaluate("playground.stage.renderer.shadowMap.enabled = false");
  return { page, complaints, elsewhere, bytes: () => bytes };
}
