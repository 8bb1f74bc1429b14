/** Copied nodes: kept for all pages of this browser, so that they are pasted into other files and windows too. */
import type { Part } from "../protocol/generated";

const KEY = "grip.clipboard";

export function keepParts(parts: readonly Part[]): void {
  localStorage.setItem(KEY, JSON.stringify(parts));
}

export function keptParts(): Part[] {
  try {
    const parts: unknown = JSON.parse(localStorage.getItem(KEY) ?? "[]");
    return Array.isArray(parts) ? (parts as Part[]) : [];
  } catch {
    return [];
  }
}
