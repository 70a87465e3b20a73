"""A page that follows a server's requests: a small server of the page itself, on this machine only."""
