// What comes many times a second and is painted: samples are taken in the frames of the page, in their order, as many as
// a frame has time for. The others wait for the next one.
//
// Nobody knows beforehand how much time that is: the browser lays out and composes the page after us, and other programs
// need the processor, too. So the time is found as a sender finds the rate of a line: a frame that comes late takes a part
// of it away, each other one adds a little. The page stays quick on a weak machine, whose pictures are newer less often.

const budgetMax = 5; // ms of a frame of 16.7: to lay out and to compose what was painted takes the browser longer than to paint it
const budgetMin = 1;
const gain = 0.01; // ms a frame
const loss = 0.5; // at a late frame
const late = 25; // ms from asking for a frame to its begin

export interface Frames {
  now(): number; // ms
  request(begin: () => void): void;
}

export class FrameQueue<Item> {
  private readonly items: Item[] = [];
  private budget = budgetMax;
  private asked = 0;

  // `ended`: after each frame, with what was taken in it.
  constructor(
    private readonly frames: Frames,
    private readonly take: (item: Item) => void,
    private readonly ended: (taken: Item[]) => void,
  ) {}

  push(item: Item): void {
    if (this.items.push(item) === 1) this.ask();
  }

  private ask(): void {
    this.asked = this.frames.now();
    this.frames.request(() => this.frame());
  }

  private frame(): void {
    const begin = this.frames.now();
    const isLate = begin - this.asked > late;
    this.budget = isLate ? Math.max(budgetMin, this.budget * loss) : Math.min(budgetMax, this.budget + gain);
    let count = 0;
    while (count < this.items.length && (count === 0 || this.frames.now() - begin < this.budget))
      this.take(this.items[count++] as Item);
    const taken = this.items.splice(0, count);
    if (this.items.length > 0) this.ask();
    this.ended(taken);
  }
}
