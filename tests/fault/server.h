#pragma once

/* What a request runs: main() with these arguments, and faults counted from here. */
struct Server {
  int (*run)(int count, char** arguments);
};

/* Answers requests, if the environment asks for that, and does not come back (server.c). */
void serve(const struct Server* server);
