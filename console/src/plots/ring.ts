// The newest samples of a curve; the oldest give way. Pure.

export class Ring {
  private at: Float64Array;
  private values: Float64Array;
  private count = 0;

  constructor(private readonly capacity: number) {
    this.at = new Float64Array(capacity);
    this.values = new Float64Array(capacity);
  }

  add(time: number, value: number): void {
    const i = this.count % this.capacity;
    this.at[i] = time;
    this.values[i] = value;
    ++this.count;
  }

  get newest(): number | undefined {
    return this.count === 0 ? undefined : this.values[(this.count - 1) % this.capacity];
  }

  // From the oldest to the newest.
  each(take: (time: number, value: number) => void): void {
    for (let i = Math.max(0, this.count - this.capacity); i < this.count; ++i) {
      const place = i % this.capacity;
      take(this.at[place] ?? 0, this.values[place] ?? 0);
    }
  }
}
