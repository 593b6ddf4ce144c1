// A page for measurements. Playwright is told of each message of a page's WebSocket, whole: at 1 500 messages a second
// that takes more of the machine than the page itself. This one is told only what it asks for.

export class BarePage {
  answers = new Map(); // of DevTools, by the number of the request
  requests = 0;

  static async open(browser, url, { width, height }) {
    const page = new BarePage();
    page.tools = await browser.newBrowserCDPSession();
    const { targetId } = await page.tools.send('Target.createTarget', { url, width, height });
    const { sessionId } = await page.tools.send('Target.attachToTarget', { targetId, flatten: false });
    page.sessionId = sessionId;
    page.targetId = targetId;
    page.tools.on('Target.receivedMessageFromTarget', ({ message }) => {
      const answer = JSON.parse(message);
      page.answers.get(answer.id)?.(answer);
      page.answers.delete(answer.id);
    });
    return page;
  }

  // A command of the DevTools protocol.
  async send(method, params = {}) {
    const id = ++this.requests;
    const answered = new Promise((resolve) => this.answers.set(id, resolve));
    const message = JSON.stringify({ id, method, params });
    await this.tools.send('Target.sendMessageToTarget', { sessionId: this.sessionId, message });
    const { result, error } = await answered;
    if (error !== undefined) throw new Error(`${method}: ${error.message}`);
    return result;
  }

  async evaluate(program, argument) {
    const { result, exceptionDetails } = await this.send('Runtime.evaluate', {
      expression: `(${program})(${JSON.stringify(argument)})`,
      awaitPromise: true,
      returnByValue: true,
    });
    if (exceptionDetails !== undefined) throw new Error(exceptionDetails.exception?.description);
    return result.value;
  }

  async close() {
    await this.tools.send('Target.closeTarget', { targetId: this.targetId });
  }
}
