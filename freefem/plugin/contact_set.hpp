// Frictionless contact on a known elastic compliance: find lambda >= 0 with
//   (28) A lambda >= b,   lambda . (A lambda - b) = 0,   A_ij = n_i . C_ij n_j,
// b the overlap that would be left without the forces.  Primal-dual active set, warm-started from the lambda handed in;
// the twin of freefem/lib/contact_lcp.idp.
#ifndef PEEN_CONTACT_SET_HPP
#define PEEN_CONTACT_SET_HPP

#include <cmath>
#include <vector>

// x <- A^-1 x, A (m x m, symmetric positive definite, lower triangle used, overwritten); false: it is not.
inline bool choleskySolve(std::vector<double> &A, int m, std::vector<double> &x) {
    for (int j = 0; j < m; ++j) {
        double *a = &A[size_t(j) * m];
        for (int k = 0; k < j; ++k) {
            const double *b = &A[size_t(k) * m];
            double sum = a[k];
            for (int i = 0; i < k; ++i) sum -= a[i] * b[i];
            a[k] = sum / b[k];
        }
        double d = a[j];
        for (int i = 0; i < j; ++i) d -= a[i] * a[i];
        if (!(d > 0)) return false;
        a[j] = std::sqrt(d);
    }
    for (int j = 0; j < m; ++j) {
        for (int i = 0; i < j; ++i) x[j] -= A[size_t(j) * m + i] * x[i];
        x[j] /= A[size_t(j) * m + j];
    }
    for (int j = m - 1; j >= 0; --j) {
        x[j] /= A[size_t(j) * m + j];
        for (int i = 0; i < j; ++i) x[i] -= A[size_t(j) * m + i] * x[j];
    }
    return true;
}

// Returns the number of sweeps, or -1: the set cycles, or A is not positive definite.
inline int contactSet(const std::vector<double> &A, const std::vector<double> &b, std::vector<double> &lambda) {
    const int n = int(b.size()), most = 60;
    std::vector<char> active(n), before(n, 2);
    std::vector<int> index;
    std::vector<double> part, x;
    for (int sweep = 0; sweep < most; ++sweep) {
        index.clear();
        for (int i = 0; i < n; ++i) {
            double slack = -b[i]; // > 0: the surface has left the sphere
            for (int j = 0; j < n; ++j)
                if (lambda[j] != 0) slack += A[size_t(i) * n + j] * lambda[j];
            active[i] = lambda[i] > 0 || slack < -1e-14;
            if (active[i]) index.push_back(i);
        }
        if (active == before) return sweep;
        before = active;
        const int m = int(index.size());
        part.resize(size_t(m) * m);
        x.resize(m);
        for (int i = 0; i < m; ++i) {
            x[i] = b[index[i]];
            for (int j = 0; j < m; ++j) part[size_t(i) * m + j] = A[size_t(index[i]) * n + index[j]];
        }
        if (!choleskySolve(part, m, x)) return -1;
        lambda.assign(n, 0);
        for (int i = 0; i < m; ++i) lambda[index[i]] = x[i];
    }
    return -1;
}

#endif
