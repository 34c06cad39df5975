// One sparse Cholesky factorisation P K P^T = L L^T (CHOLMOD, supernodal, METIS), kept as a single-precision copy for
// many solves: these read L once each way and do little with it, so that half the bytes are nearly twice the speed.
// Its callers iterate on a residual computed in double precision; the solves only have to point the right way.
//
// Supernodes form a tree: a right-hand side that is zero outside some entries touches only their supernodes and the
// ancestors of these on the way down, and a solution wanted at some entries needs only those on the way up.
#ifndef PEEN_SUPERNODAL_HPP
#define PEEN_SUPERNODAL_HPP

#include <cmath>
#include <numeric>
#include <vector>

#include <cblas.h>
#include <suitesparse/cholmod.h>

class Supernodal {
  public:
    int n = 0;
    std::vector<int> place; // of each unknown in the order of elimination

    // K: lower triangle as triplets (row, column, value), n unknowns; `fixed` ones are taken out.  False: not positive
    // definite, or too large for 32-bit indices.
    bool factorise(int unknowns, long count, const long *row, const long *col, const double *value, const double *fixed) {
        cholmod_common c;
        cholmod_start(&c);
        c.nmethods = 1;
        c.method[0].ordering = CHOLMOD_METIS;
        c.supernodal = CHOLMOD_SUPERNODAL;
        c.print = 0;
        n = unknowns;
        cholmod_triplet *t = cholmod_allocate_triplet(n, n, count + n, -1, CHOLMOD_REAL, &c);
        int *ti = static_cast<int *>(t->i), *tj = static_cast<int *>(t->j);
        double *tx = static_cast<double *>(t->x);
        size_t k = 0;
        for (long i = 0; i < count; ++i) {
            if (row[i] < col[i] || fixed[row[i]] > 0 || fixed[col[i]] > 0) continue;
            ti[k] = int(row[i]), tj[k] = int(col[i]), tx[k++] = value[i];
        }
        for (int i = 0; i < n; ++i)
            if (fixed[i] > 0) ti[k] = tj[k] = i, tx[k++] = 1;
        t->nnz = k;
        cholmod_sparse *A = cholmod_triplet_to_sparse(t, k, &c);
        cholmod_free_triplet(&t, &c);
        cholmod_factor *L = cholmod_analyze(A, &c);
        bool good = L != nullptr && cholmod_factorize(A, L, &c) && c.status == CHOLMOD_OK && L->minor == L->n;
        cholmod_free_sparse(&A, &c);
        if (good) copy(*L);
        cholmod_free_factor(&L, &c);
        cholmod_finish(&c);
        return good;
    }

    int supernodes() const { return int(first.size()) - 1; }
    size_t entries() const { return x.size(); }

    // Stamps the supernodes of these unknowns and all their ancestors.
    void mark(const long *unknowns, long count, std::vector<char> &on) const {
        on.assign(supernodes(), 0);
        for (long i = 0; i < count; ++i) markPlace(place[unknowns[i]], on);
    }
    // Likewise for one, by its place in the order of elimination.
    void markPlace(int at, std::vector<char> &on) const {
        for (int s = owner[at]; s >= 0 && !on[s]; s = parent[s]) on[s] = 1;
    }

    // Y (n x columns, order of elimination) <- L^-1 Y, through the supernodes that are on (nullptr: all).
    void down(float *Y, int columns, const std::vector<char> *on) const {
        std::vector<float> w(size_t(widest) * columns);
        for (int s = 0; s < supernodes(); ++s) {
            if (on && !(*on)[s]) continue;
            const int wide = first[s + 1] - first[s], tall = rowStart[s + 1] - rowStart[s], rest = tall - wide;
            const float *B = &x[start[s]];
            float *own = Y + first[s];
            const int *rows = &row[rowStart[s] + wide];
            if (columns == 1) {
                cblas_strsv(CblasColMajor, CblasLower, CblasNoTrans, CblasNonUnit, wide, B, tall, own, 1);
                if (rest == 0) continue;
                cblas_sgemv(CblasColMajor, CblasNoTrans, rest, wide, 1, B + wide, tall, own, 1, 0, w.data(), 1);
            } else {
                cblas_strsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, wide, columns, 1, B, tall, own, n);
                if (rest == 0) continue;
                cblas_sgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, rest, columns, wide, 1, B + wide, tall, own, n, 0, w.data(), rest);
            }
            for (int c = 0; c < columns; ++c)
                for (int i = 0; i < rest; ++i) Y[rows[i] + size_t(c) * n] -= w[i + size_t(c) * rest];
        }
    }

    // Y <- L^-T Y likewise.
    void up(float *Y, int columns, const std::vector<char> *on) const {
        std::vector<float> w(size_t(widest) * columns);
        for (int s = supernodes() - 1; s >= 0; --s) {
            if (on && !(*on)[s]) continue;
            const int wide = first[s + 1] - first[s], tall = rowStart[s + 1] - rowStart[s], rest = tall - wide;
            const float *B = &x[start[s]];
            float *own = Y + first[s];
            const int *rows = &row[rowStart[s] + wide];
            for (int c = 0; c < columns; ++c)
                for (int i = 0; i < rest; ++i) w[i + size_t(c) * rest] = Y[rows[i] + size_t(c) * n];
            if (columns == 1) {
                if (rest > 0) cblas_sgemv(CblasColMajor, CblasTrans, rest, wide, -1, B + wide, tall, w.data(), 1, 1, own, 1);
                cblas_strsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, wide, B, tall, own, 1);
            } else {
                if (rest > 0) cblas_sgemm(CblasColMajor, CblasTrans, CblasNoTrans, wide, columns, rest, -1, B + wide, tall, w.data(), rest, 1, own, n);
                cblas_strsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, wide, columns, 1, B, tall, own, n);
            }
        }
    }

  private:
    std::vector<int> first, rowStart, row, owner, parent; // columns, row lists; supernode of a column, its parent or -1
    std::vector<size_t> start;
    std::vector<float> x;
    int widest = 1; // longest row list

    void copy(const cholmod_factor &L) {
        const int count = int(L.nsuper);
        const int *super = static_cast<int *>(L.super), *pi = static_cast<int *>(L.pi), *px = static_cast<int *>(L.px);
        const int *s = static_cast<int *>(L.s), *perm = static_cast<int *>(L.Perm);
        const double *value = static_cast<double *>(L.x);
        first.assign(super, super + count + 1);
        rowStart.assign(pi, pi + count + 1);
        start.assign(px, px + count + 1);
        row.assign(s, s + pi[count]);
        x.resize(px[count]);
        for (size_t i = 0; i < x.size(); ++i) x[i] = float(value[i]);
        place.resize(n);
        for (int i = 0; i < n; ++i) place[perm[i]] = i;
        owner.resize(n);
        parent.assign(count, -1);
        widest = 1;
        for (int k = 0; k < count; ++k) {
            for (int i = first[k]; i < first[k + 1]; ++i) owner[i] = k;
            widest = std::max(widest, rowStart[k + 1] - rowStart[k]);
        }
        for (int k = 0; k < count; ++k) {
            const int below = rowStart[k] + first[k + 1] - first[k];
            if (below < rowStart[k + 1]) parent[k] = owner[row[below]];
        }
    }
};

#endif
