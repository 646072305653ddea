const KEY = "facebaker-token";

let token: string | null = null;

/**
 * Takes the token out of the address that `facebaker view` prints, so that links to poses do not carry it. It is kept
 * for other pages of the same server, where the browser keeps anything; a token of an earlier run opens nothing.
 */
export function takeToken(): void {
  const address = new URL(location.href);
  token = address.searchParams.get("token");
  try {
    if (token === null) token = localStorage.getItem(KEY);
    else localStorage.setItem(KEY, token);
  } catch {
    // it is kept for this page alone
  }
  if (!address.searchParams.has("token")) return;
  address.searchParams.delete("token");
  history.replaceState(null, "", address);
}

/** What requests carry that have the server run a rig. */
export function tokenHeaders(): HeadersInit {
  return token === null ? {} : { Authorization: `Bearer ${token}` };
}
