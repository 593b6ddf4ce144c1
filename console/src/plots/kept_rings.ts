// The samples of curves by their names: they stay when another curve is added, when a robot is away for a while, and while
// another page is visited. Pure.

import { Ring } from './ring';

export class KeptRings<Curve extends { name: string }> {
  private readonly kept = new Map<string, { curve: Curve; ring: Ring }>();

  constructor(
    private readonly samplesMax: number,
    private readonly curvesMax: number,
  ) {}

  // Made when there is none; those that were asked for longest ago give way.
  of(curve: Curve): Ring {
    const ring = this.kept.get(curve.name)?.ring ?? new Ring(this.samplesMax);
    this.kept.delete(curve.name);
    this.kept.set(curve.name, { curve, ring });
    for (const name of this.kept.keys()) {
      if (this.kept.size <= this.curvesMax) break;
      this.kept.delete(name);
    }
    return ring;
  }

  // A curve that was asked for: also when nothing of its component is known any more.
  curve(name: string): Curve | undefined {
    return this.kept.get(name)?.curve;
  }
}
