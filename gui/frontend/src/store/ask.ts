/** Questions to the person: one at a time, answered in a dialog; null when it is closed without an answer. */
import { create } from "zustand";

import { FEW } from "../model/values";
import type { FolderView } from "../protocol/generated";

export interface Option {
  readonly value: string;
  readonly label: string;
  /** Said in a second line. */
  readonly detail?: string;
  /** Said at the end of the line: a key, a kind. */
  readonly mark?: string;
}

export interface TextQuestion {
  readonly kind: "text";
  readonly title: string;
  readonly label: string;
  readonly initial: string;
  readonly hint?: string;
  /** Why an answer won't do; empty when it will. */
  readonly check?: (text: string) => string;
}

export interface ChoiceQuestion {
  readonly kind: "choice";
  readonly title: string;
  readonly label: string;
  readonly options: readonly Option[];
  /** Whether typing looks for something, however few there are. */
  readonly search?: boolean;
  /** Said above the list. */
  readonly lead?: string;
  /** Texts that are shown side by side above the list. */
  readonly columns?: readonly { readonly title: string; readonly lines: readonly string[] }[];
}

/** Asks for a file or a folder of the machine that the server runs on. */
export interface FileQuestion {
  readonly kind: "file";
  readonly title: string;
  /** What can be chosen: of a file, its name decides; of a folder, what it is. */
  readonly fits: (entry: { readonly name: string; readonly kind: FolderView["kind"] }) => boolean;
}

/** Whether a choice is made among buttons; where what is offered is searched, it never is. */
export const isFew = ({ options, search }: Pick<ChoiceQuestion, "options" | "search">): boolean => !search && options.length <= FEW;

export type Question = TextQuestion | ChoiceQuestion | FileQuestion;

interface AskStore {
  readonly question: Question | null;
  readonly answer: (value: string | null) => void;
}

export const useAsk = create<AskStore>()(() => ({ question: null, answer: () => {} }));

export function ask(question: Question): Promise<string | null> {
  useAsk.getState().answer(null);
  return new Promise((resolve) => {
    useAsk.setState({
      question,
      answer: (value) => {
        useAsk.setState({ question: null, answer: () => {} });
        resolve(value);
      },
    });
  });
}

export const askText = (question: Omit<TextQuestion, "kind">): Promise<string | null> => ask({ kind: "text", ...question });
export const askFile = (question: Omit<FileQuestion, "kind">): Promise<string | null> => ask({ kind: "file", ...question });
export const askChoice = (question: Omit<ChoiceQuestion, "kind">): Promise<string | null> => ask({ kind: "choice", ...question });

let expected = 0;

/** Whether a question is on its way: what is typed meanwhile is meant for it, and for nothing else. */
export const isExpected = (): boolean => expected > 0;

/** Do something that asks once it has looked. */
export async function expecting(work: () => unknown): Promise<void> {
  expected++;
  try {
    await work();
  } finally {
    expected--;
  }
}
