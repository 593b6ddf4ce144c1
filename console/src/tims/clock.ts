// One clock for a page and its worker. That of performance.now() begins when each of them begins, the worker's by as
// much later as the page took to load.

// performance.now() of whoever's began at `origin`, its performance.timeOrigin.
export function clockOf(origin: number, own: Pick<Performance, 'now' | 'timeOrigin'> = performance): () => number {
  const later = own.timeOrigin - origin;
  return () => own.now() + later;
}
