// The state of a run on disk.  Included by peen_block.cpp alone.
#ifndef PEEN_BLOCK_CHECKPOINT_HPP
#define PEEN_BLOCK_CHECKPOINT_HPP

#include "AFunction_ext.hpp"
#include "block_point.hpp"

#include <cstdio>

namespace {

const long CHECKPOINT = 0x7065656e0001; // first number of the file: its format

// A checkpoint: `inputs` (whatever tells one run from another), U, states and the history table, in binary; written
// beside and renamed, so that a file that exists is whole.
long peenWrite(string *const &file, KN<double> *const &inputs, KN<double> *const &U, KNM<double> *const &state,
               KNM<double> *const &history) {
    const string part = *file + ".part";
    FILE *f = std::fopen(part.c_str(), "wb");
    ffassert(f);
    const long head[6] = {CHECKPOINT, inputs->N(), U->N(), state->M(), history->N(), history->M()};
    bool good = std::fwrite(head, sizeof head, 1, f) == 1;
    auto put = [&](const double *x, size_t n) { good = good && std::fwrite(x, sizeof(double), n, f) == n; };
    put(&(*inputs)[0], inputs->N());
    put(&(*U)[0], U->N());
    put(&(*state)(0L, 0L), size_t(block::STATE) * state->M());
    put(&(*history)(0L, 0L), size_t(history->N()) * history->M());
    good = std::fflush(f) == 0 && good;
    good = std::fclose(f) == 0 && good;
    ffassert(good);
    ffassert(std::rename(part.c_str(), file->c_str()) == 0);
    return 0;
}

// Returns 1 when the checkpoint was read, 0 without one, -1 for one of other inputs; then nothing is changed.
long peenRead(string *const &file, KN<double> *const &inputs, KN<double> *const &U, KNM<double> *const &state,
              KNM<double> *const &history) {
    FILE *f = std::fopen(file->c_str(), "rb");
    if (!f) return 0;
    const long head[6] = {CHECKPOINT, inputs->N(), U->N(), state->M(), history->N(), history->M()};
    long found[6];
    const size_t sizes[4] = {size_t(head[1]), size_t(head[2]), size_t(block::STATE * head[3]), size_t(head[4] * head[5])};
    std::vector<double> part[4];
    bool good = std::fread(found, sizeof found, 1, f) == 1 && std::equal(head, head + 6, found);
    for (int i = 0; i < 4 && good; ++i) {
        part[i].resize(sizes[i]);
        good = std::fread(part[i].data(), sizeof(double), sizes[i], f) == sizes[i];
    }
    std::fclose(f);
    if (!good || !std::equal(part[0].begin(), part[0].end(), &(*inputs)[0])) return -1;
    std::copy(part[1].begin(), part[1].end(), &(*U)[0]);
    std::copy(part[2].begin(), part[2].end(), &(*state)(0L, 0L));
    std::copy(part[3].begin(), part[3].end(), &(*history)(0L, 0L));
    return 1;
}

} // namespace

#endif
