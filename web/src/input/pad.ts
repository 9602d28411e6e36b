/** The pad for thumbs: a knob in a ring. */

export function bindPad(ring: HTMLElement, knob: HTMLElement, set: (place: [number, number] | null) => void): void {
  const place = (event: PointerEvent): [number, number] => {
    const box = ring.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1;
    const y = 1 - (2 * (event.clientY - box.top)) / box.height;
    const far = Math.max(1, Math.hypot(x, y));
    return [x / far, y / far];
  };
  const show = ([x, y]: [number, number]) => {
    knob.style.transform = `translate(${x * 28}px, ${-y * 28}px)`;
  };
  ring.addEventListener("pointerdown", (event) => {
    ring.setPointerCapture(event.pointerId);
    set(place(event));
    show(place(event));
  });
  ring.addEventListener("pointermove", (event) => {
    if (!ring.hasPointerCapture(event.pointerId)) return;
    set(place(event));
    show(place(event));
  });
  for (const kind of ["pointerup", "pointercancel"] as const) {
    ring.addEventListener(kind, () => {
      set(null);
      show([0, 0]);
    });
  }
}
