/** The task file that is open: its newest state, what it can be made of, and what stands in the way of an edit. */
import { create } from "zustand";

import type { CatalogView, DocumentView, FormsView } from "../protocol/generated";

/** Why the last request wasn't done, where the person can decide. */
export interface Conflict {
  readonly kind: string;
  readonly message: string;
  /** A text that was typed and not taken yet. */
  readonly text?: string;
}

export interface DocumentStore {
  readonly document: DocumentView | null;
  readonly catalog: CatalogView;
  readonly forms: FormsView | null;
  readonly conflict: Conflict | null;
  /** How many edits wait for a server that doesn't answer. */
  readonly waiting: number;
  /** Told to people who don't see the canvas. */
  readonly said: string;
  /** Grows when the text view is to give up what was typed there and take the document's text. */
  readonly resets: number;
  setDocument(document: DocumentView | null): void;
  setCatalog(catalog: CatalogView): void;
  setForms(forms: FormsView): void;
  setConflict(conflict: Conflict | null): void;
  say(said: string): void;
  resetText(): void;
}

export const useDocument = create<DocumentStore>()((set) => ({
  document: null,
  catalog: { nodes: [], tasks: [], error: "" },
  forms: null,
  conflict: null,
  waiting: 0,
  said: "",
  resets: 0,
  setDocument: (document) => set((s) => ({ document, forms: s.document?.path === document?.path ? s.forms : null })),
  setCatalog: (catalog) => set({ catalog }),
  setForms: (forms) => set({ forms }),
  setConflict: (conflict) => set({ conflict }),
  say: (said) => set({ said }),
  resetText: () => set((s) => ({ resets: s.resets + 1, conflict: null })),
}));
