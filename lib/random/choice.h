#pragma once
/// Some of many by chance.
#include <cstdint>
#include <vector>

#include "random/stream.h"

namespace surveymc::random {

/// `count` of 0, ..., of - 1, every subset as likely, in the order in which they are drawn: by uniforms first, ...,
/// first + count - 1 of the channel. count is at most `of`.
std::vector<int> choose(const Stream& stream, std::uint64_t trial, Channel channel, std::uint32_t first, int of,
                        int count);
/// One of 0, ..., of - 1, each as likely, by one uniform of the channel.
int choose_one(const Stream& stream, std::uint64_t trial, Channel channel, std::uint32_t index, int of);

}  // namespace surveymc::random
