// Questions to the router about itself: JSON in messages of type 64, answered by type -64.

import type { Client } from '../tims/client';
import { types } from '../tims/header';
import { hindrance } from '../tims/login';
import { neededForQuestion } from '../tims/rights';

export class AdminError extends Error {
  constructor(
    readonly code: string,
    message: string,
    readonly hint: string,
  ) {
    super(message);
  }
}

export type Question = { ask: string } & Record<string, unknown>;

interface Page<Item> {
  items: Item[];
  next?: string;
}

const answerTime = 3000;

export class Admin {
  constructor(private readonly client: Client) {}

  // `router`: the address of another one; 0: the own.
  async ask<Answer>(question: Question, timeout = answerTime, router = 0): Promise<Answer> {
    const why = hindrance(neededForQuestion(question.ask));
    if (why !== '') throw new Error(why);
    const body = new TextEncoder().encode(JSON.stringify(question));
    const answer = await this.client.call(router, types.adminRequest, body, timeout);
    if (answer.type !== types.adminReply) throw new AdminError('no_answer', 'the router is not there', '');
    const value = JSON.parse(new TextDecoder().decode(answer.body));
    if (value.error !== undefined) throw new AdminError(value.error.code, value.error.message, value.error.hint ?? '');
    return value;
  }

  // All pages of a list.
  async all<Item>(question: Question, router = 0): Promise<Item[]> {
    const items: Item[] = [];
    let after: string | undefined;
    do {
      const page: Page<Item> = await this.ask(
        { ...question, ...(after !== undefined && { after }) },
        answerTime,
        router,
      );
      items.push(...page.items);
      after = page.next;
    } while (after !== undefined);
    return items;
  }
}
