import "@xyflow/react/dist/style.css";
import "./view/page.css";
import "./view/edit.css";

import { StrictMode } from "react";
import { createRoot } from "react-dom/client";

import { Page } from "./view/Page";

createRoot(document.getElementById("page") as HTMLElement).render(
  <StrictMode>
    <Page />
  </StrictMode>,
);
