// Requests that wait for their answers. The sequence number of the header has 8 bits, so at most 255 requests to one
// component are under way (0 marks the connection's own); an answer is recognised by its sender and this number.

export interface Answer {
  type: number;
  flags: number;
  body: Uint8Array;
}

export class CallFailure extends Error {}

interface Call {
  deadline: number;
  resolve: (answer: Answer) => void;
  reject: (failure: CallFailure) => void;
}

const callsMax = 255;

export class Calls {
  private waiting = new Map<string, Call>();
  private next = 1;

  // The sequence number for a request; undefined: too many are under way.
  begin(receiver: number, deadline: number, resolve: Call['resolve'], reject: Call['reject']): number | undefined {
    for (let tried = 0; tried < callsMax; ++tried) {
      const number = this.next;
      this.next = (this.next % callsMax) + 1;
      const key = `${receiver}:${number}`;
      if (this.waiting.has(key)) continue;
      this.waiting.set(key, { deadline, resolve, reject });
      return number;
    }
    return undefined;
  }

  // False: nobody waits for it.
  answer(sender: number, number: number, answer: Answer): boolean {
    const key = `${sender}:${number}`;
    const call = this.waiting.get(key);
    if (call === undefined) return false;
    this.waiting.delete(key);
    call.resolve(answer);
    return true;
  }

  expire(now: number): void {
    for (const [key, call] of this.waiting)
      if (call.deadline <= now) {
        this.waiting.delete(key);
        call.reject(new CallFailure('no answer in time'));
      }
  }

  fail(why: string): void {
    const calls = [...this.waiting.values()];
    this.waiting.clear();
    for (const call of calls) call.reject(new CallFailure(why));
  }
}
