#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "config/suggest.h"

using namespace surveymc::config;

namespace {

const std::vector<std::string> kNames{"msa", "msa_weighted", "msa_joint", "MWD+IFR1", "MWD+IFR2", "run", "rerun"};

}  // namespace

TEST_CASE("The nearest name is the one with the fewest typing errors, whatever the case") {
  CHECK(nearest("MSA", kNames) == "msa");
  CHECK(nearest("mwd+ifr1", kNames) == "MWD+IFR1");
  CHECK(nearest("MWD+IFR3", kNames) == "MWD+IFR1 or MWD+IFR2");
  CHECK(nearest("msa_wieghted", kNames) == "msa_weighted");
  CHECK(nearest("Msa_Weigted", kNames) == "msa_weighted");
  CHECK(nearest("rnu", kNames) == "run");
  CHECK(nearest("Run", kNames) == "run");
  CHECK(nearest("R", {"r", "s"}) == "r");
}

TEST_CASE("Else those that begin with the word are meant, if they are few") {
  CHECK(nearest("msa_", kNames) == "msa");  // one letter too many
  CHECK(nearest("msa_j", kNames) == "msa_joint");
  CHECK(nearest("MWD", kNames) == "MWD+IFR1 or MWD+IFR2");
  CHECK(nearest("m", kNames).empty());
  CHECK(nearest("ab", {"aba", "abcde1", "abcde2", "abcde3", "abcde4", "abcde5"}) == "aba");
  CHECK(nearest("abcde", {"abcdefgh1", "abcdefgh2", "abcdefgh3", "abcdefgh4", "abcdefgh5"}).empty());
}

TEST_CASE("Nothing is meant by words that are far from all names, empty or very long") {
  for (const std::string& word : {std::string("xyz"), std::string(), std::string(" "), std::string(100'000, 'm')})
    CHECK(nearest(word, kNames).empty());
  CHECK(nearest("msa", {}).empty());
}

TEST_CASE("A message ends with what may be meant, in quotes") {
  CHECK(suggestion("MSA", kNames) == "; did you mean \"msa\"?");
  CHECK(suggestion("MWD", kNames) == "; did you mean \"MWD+IFR1\" or \"MWD+IFR2\"?");
  CHECK(suggestion("xyz", kNames).empty());
  CHECK(none_of("smal", {"small", "large"}) == "\"smal\" is none of small, large; did you mean \"small\"?");
  CHECK(none_of("?", {"small", "large"}) == "\"?\" is none of small, large");
}
