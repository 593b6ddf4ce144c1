// A tone that follows a number.

const loudness = 0.08;
const glide = 0.05; // s

export class Tone {
  private readonly context = new AudioContext();
  private readonly oscillator = this.context.createOscillator();
  private readonly volume = this.context.createGain();

  constructor() {
    this.volume.gain.value = 0;
    this.oscillator.connect(this.volume).connect(this.context.destination);
    this.oscillator.start();
  }

  play(frequency: number, isHeard: boolean): void {
    const now = this.context.currentTime;
    this.oscillator.frequency.setTargetAtTime(frequency, now, glide);
    this.volume.gain.setTargetAtTime(isHeard ? loudness : 0, now, glide);
  }

  end(): void {
    void this.context.close();
  }
}
