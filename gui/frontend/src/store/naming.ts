/** Asks the person how the other pages should call this one. */
import { PAGE } from "../protocol/client";
import { askText } from "./ask";
import { callMe } from "./desk";
import { LONGEST_NAME } from "./presence";
import { useRunning } from "./runDesk";

export async function askForName(): Promise<void> {
  const initial = useRunning.getState().desk.onlookers.find((each) => each.page === PAGE)?.name ?? "";
  const check = (text: string): string => (text.trim() === "" ? "a name is needed" : text.trim().length > LONGEST_NAME ? `at most ${LONGEST_NAME} characters` : "");
  const name = await askText({ title: "Your name", label: "Everybody who looks on sees it.", initial, check });
  if (name !== null) callMe(name);
}
