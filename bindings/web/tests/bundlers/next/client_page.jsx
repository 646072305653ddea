import { InBrowser } from "./in_browser";

// In place of page.jsx: nothing is posed by the server.
export default function ClientPage() {
  return <InBrowser />;
}
