#include "io/image/deflate_runs.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

namespace kappamu::io {

namespace {

// Shorter blocks follow the picture's brightness better; their codes take some 80 bytes each.
constexpr std::size_t block_bytes = 65536;
constexpr std::size_t shortest_run = 3, longest_run = 258;
constexpr int end_of_block = 256;
constexpr std::size_t symbols = 286;  // literals, end of block, lengths of runs

// Lengths of runs have 29 codes with up to five extra bits (RFC 1951, section 3.2.5).
struct RunLength {
  std::uint16_t symbol = 0;
  std::uint8_t extra_bits = 0;
  std::uint8_t extra = 0;
};
constexpr std::array<RunLength, longest_run + 1> make_run_lengths() {
  std::array<RunLength, longest_run + 1> table{};
  std::size_t length = shortest_run;
  for (int code = 0; code < 28; ++code) {
    const int bits = code < 8 ? 0 : (code - 4) / 4;
    for (int extra = 0; extra < 1 << bits && length < longest_run; ++extra, ++length) {
      table[length] = {static_cast<std::uint16_t>(257 + code), static_cast<std::uint8_t>(bits),
                       static_cast<std::uint8_t>(extra)};
    }
  }
  table[longest_run] = {285, 0, 0};
  return table;
}
constexpr std::array<RunLength, longest_run + 1> run_lengths = make_run_lengths();

struct Code {
  std::uint16_t bits = 0;   // first bit lowest, as they are written
  std::uint8_t length = 0;  // 0: the symbol does not occur
};

class BitWriter {
 public:
  // The bytes go to `out` from `at` on, which must have room for them and eight more.
  explicit BitWriter(std::uint8_t* at) : at_(at) {}

  // At most 48 bits between two calls of flush().
  void hold(std::uint32_t bits, int count) {
    held_ |= static_cast<std::uint64_t>(bits) << count_;
    count_ += count;
  }
  void hold(Code code) { hold(code.bits, code.length); }
  void flush() {
    for (int i = 0; i < 8; ++i) at_[i] = static_cast<std::uint8_t>(held_ >> 8 * i);  // one store
    at_ += count_ >> 3;
    held_ >>= count_ & ~7;
    count_ &= 7;
  }
  void put(std::uint32_t bits, int count) {
    hold(bits, count);
    flush();
  }
  // An empty stored block, after which the next byte begins.
  std::uint8_t* finish() {
    put(0, 3);
    if (count_ > 0) ++at_;
    for (const int byte : {0x00, 0x00, 0xFF, 0xFF}) *at_++ = static_cast<std::uint8_t>(byte);
    return at_;
  }

 private:
  std::uint8_t* at_;
  std::uint64_t held_ = 0;
  int count_ = 0;
};

// Depths of the leaves of Huffman's tree (two queues: leaves by weight, inner nodes as they are
// made). Too deep a tree is made again with weights closer to each other.
template <std::size_t N>
std::array<std::uint8_t, N> code_lengths(std::array<std::uint32_t, N> weights, int longest) {
  std::array<std::uint8_t, N> lengths{};
  std::array<std::uint16_t, N> leaves;
  std::size_t count = 0;
  for (std::size_t s = 0; s < N; ++s) {
    if (weights[s] > 0) leaves[count++] = static_cast<std::uint16_t>(s);
  }
  if (count == 0) return lengths;
  if (count == 1) {
    lengths[leaves[0]] = 1;
    return lengths;
  }
  while (true) {
    std::sort(leaves.begin(), leaves.begin() + static_cast<std::ptrdiff_t>(count),
              [&](std::uint16_t a, std::uint16_t b) {
                return weights[a] != weights[b] ? weights[a] < weights[b] : a < b;
              });
    std::array<std::uint32_t, 2 * N> weight{};
    std::array<std::uint16_t, 2 * N> parent{};
    for (std::size_t i = 0; i < count; ++i) weight[i] = weights[leaves[i]];
    std::size_t leaf = 0, inner = count;
    const auto lightest = [&](std::size_t made) {
      return leaf < count && (inner == made || weight[leaf] <= weight[inner]) ? leaf++ : inner++;
    };
    for (std::size_t made = count; made < 2 * count - 1; ++made) {
      const std::size_t one = lightest(made), other = lightest(made);
      weight[made] = weight[one] + weight[other];
      parent[one] = parent[other] = static_cast<std::uint16_t>(made);
    }
    std::array<std::uint8_t, 2 * N> depth{};
    int deepest = 0;
    for (std::size_t node = 2 * count - 2; node-- > 0;) {
      depth[node] = static_cast<std::uint8_t>(depth[parent[node]] + 1);
      deepest = std::max<int>(deepest, depth[node]);
    }
    if (deepest <= longest) {
      for (std::size_t i = 0; i < count; ++i) lengths[leaves[i]] = depth[i];
      return lengths;
    }
    for (std::uint32_t& w : weights) w = w > 0 ? (w >> 1) + 1 : 0;
  }
}

// The canonical codes of such lengths (RFC 1951, section 3.2.2).
template <std::size_t N>
std::array<Code, N> codes_of(const std::array<std::uint8_t, N>& lengths) {
  std::array<unsigned, 17> next{};
  for (const std::uint8_t length : lengths) ++next[length + 1U];
  next[1] = 0;
  unsigned code = 0;
  std::array<unsigned, 17> first{};
  for (std::size_t bits = 1; bits < 16; ++bits) {
    code = (code + (bits > 1 ? next[bits] : 0)) << 1;
    first[bits] = code;
  }
  std::array<Code, N> codes{};
  for (std::size_t s = 0; s < N; ++s) {
    if (lengths[s] == 0) continue;
    unsigned bits = first[lengths[s]]++;
    unsigned turned = 0;
    for (int i = 0; i < lengths[s]; ++i, bits >>= 1) turned = turned << 1 | (bits & 1U);
    codes[s] = {static_cast<std::uint16_t>(turned), lengths[s]};
  }
  return codes;
}

// The block's codes, themselves coded by their lengths (section 3.2.7). Runs have one distance, 1.
void put_header(const std::array<std::uint8_t, symbols>& lengths, BitWriter& writer) {
  struct Step {
    std::uint8_t symbol, bits, extra;
  };
  std::array<std::uint8_t, symbols + 1> all{};
  std::copy(lengths.begin(), lengths.end(), all.begin());
  all[symbols] = 1;  // of the one distance
  std::vector<Step> steps;
  std::array<std::uint32_t, 19> weights{};
  for (std::size_t i = 0; i < all.size();) {
    std::size_t same = 1;
    while (i + same < all.size() && all[i + same] == all[i]) ++same;
    std::size_t left = same;
    const auto step = [&](int symbol, int bits, std::size_t extra, std::size_t taken) {
      steps.push_back({static_cast<std::uint8_t>(symbol), static_cast<std::uint8_t>(bits),
                       static_cast<std::uint8_t>(extra)});
      ++weights[static_cast<std::size_t>(symbol)];
      left -= taken;
    };
    if (all[i] != 0) step(all[i], 0, 0, 1);
    while (left > 0) {
      const std::size_t zeros = std::min<std::size_t>(left, 138),
                        repeats = std::min<std::size_t>(left, 6);
      if (all[i] == 0 && zeros > 10) {
        step(18, 7, zeros - 11, zeros);
      } else if (all[i] == 0 && zeros > 2) {
        step(17, 3, zeros - 3, zeros);
      } else if (all[i] != 0 && repeats > 2) {
        step(16, 2, repeats - 3, repeats);
      } else {
        step(all[i], 0, 0, 1);
      }
    }
    i += same;
  }
  constexpr std::array<std::uint8_t, 19> order{16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                               11, 4,  12, 3, 13, 2, 14, 1, 15};
  const auto step_lengths = code_lengths(weights, 7);
  const auto step_codes = codes_of(step_lengths);
  std::size_t listed = order.size();
  while (listed > 4 && step_lengths[order[listed - 1]] == 0) --listed;
  writer.put(0b100, 3);  // not the last block, codes of its own
  writer.put(symbols - 257, 5);
  writer.put(0, 5);
  writer.put(static_cast<std::uint32_t>(listed - 4), 4);
  for (std::size_t i = 0; i < listed; ++i) writer.put(step_lengths[order[i]], 3);
  for (const Step& step : steps) {
    writer.hold(step_codes[step.symbol]);
    writer.put(step.extra, step.bits);
  }
}

}  // namespace

void deflate_runs(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out) {
  // A code has at most 15 bits where the average has no more than 8 and a little: twice is enough
  // for any block, whose header takes less than 400 bytes.
  const std::size_t before = out.size();
  out.resize(before + 2 * bytes.size() + 512 * (bytes.size() / block_bytes + 1) + 32);
  BitWriter writer(out.data() + before);
  std::vector<std::uint16_t> tokens(std::min(bytes.size(), block_bytes));  // byte, or 256 + length
  for (std::size_t begin = 0; begin < bytes.size(); begin += block_bytes) {
    const std::size_t end = std::min(bytes.size(), begin + block_bytes);
    std::size_t count = 0;
    std::array<std::uint32_t, symbols> weights{};
    for (std::size_t i = begin; i < end;) {
      const std::uint8_t byte = bytes[i];
      std::size_t run = 0;
      if (i > 0 && byte == bytes[i - 1]) {
        const std::size_t most = std::min(longest_run, end - i);
        while (run < most && bytes[i + run] == byte) ++run;
      }
      if (run < shortest_run) {
        ++weights[byte];
        tokens[count++] = byte;
        ++i;
      } else {
        ++weights[run_lengths[run].symbol];
        tokens[count++] = static_cast<std::uint16_t>(256 + run);
        i += run;
      }
    }
    weights[end_of_block] = 1;
    const auto lengths = code_lengths(weights, 15);
    const auto codes = codes_of(lengths);
    put_header(lengths, writer);
    const auto is_byte = [&](std::size_t k) { return tokens[k] < 256; };
    for (std::size_t k = 0; k < count;) {
      if (k + 2 < count && is_byte(k) && is_byte(k + 1) && is_byte(k + 2)) {
        for (int i = 0; i < 3; ++i) writer.hold(codes[tokens[k++]]);
      } else if (is_byte(k)) {
        writer.hold(codes[tokens[k++]]);
      } else {
        const RunLength& run = run_lengths[tokens[k++] - 256U];
        writer.hold(codes[run.symbol]);
        writer.hold(run.extra, run.extra_bits + 1);  // and the one distance's bit, 0
      }
      writer.flush();
    }
    writer.hold(codes[end_of_block]);
    writer.flush();
  }
  out.resize(static_cast<std::size_t>(writer.finish() - out.data()));
}

}  // namespace kappamu::io
