// The script's side of the one factorisation: solves, the compliance of the contact nodes, and one correction of
// equilibrium and contact, (30).  Included by peen_block.cpp alone.
#ifndef PEEN_BLOCK_PRESS_HPP
#define PEEN_BLOCK_PRESS_HPP

#include "AFunction_ext.hpp"
#include "contact_set.hpp"
#include "supernodal.hpp"

#include <cstdio>
#include <utility>

namespace {

struct Elastic {
    Supernodal factor;
    std::vector<long> contact;     // unknowns of the contact nodes: contactComponents * candidate + component
    std::vector<float> compliance; // of these, square
    std::vector<float> base, y;    // L^-1 of the right-hand sides of peenBase and of the last peenPress
    std::vector<std::pair<int, float>> late; // (place, force) of the last peenPress that y does not hold yet
};
struct Zone {
    std::vector<long> element, unknown, skin; // skin: unknowns of nodes that elements outside share
    std::vector<char> on;                     // supernodes of its unknowns and their ancestors
};
// K^-1 of unit forces at contact nodes, at the zone's unknowns: kept as long as the zone stays, made when a node first needs one.
struct Columns {
    double x = 0, y = 0, reach = -1; // of the zone that they belong to
    std::vector<int> slot;           // of each unknown of the contact nodes, -1: none yet
    std::vector<std::vector<float>> column;
};
Elastic elastic; // one block a run
Columns columns;
int contactComponents = 3; // of a contact node that forces may have: at small strain (1) the vertical one alone, see peenMesh
Zone zone;

// The one factorisation: K by its triplets (both triangles or the lower one), unknowns with fixed > 0 taken out.
// Returns the number of entries of the factor, or -1: K is not positive definite.
long peenFactor(KN<long> *const &row, KN<long> *const &col, KN<double> *const &value, KN<double> *const &fixed) {
    ffassert(row->N() == value->N() && col->N() == value->N());
    elastic = Elastic();
    columns = Columns();
    if (!elastic.factor.factorise(int(fixed->N()), value->N(), &(*row)[0], &(*col)[0], &(*value)[0], &(*fixed)[0]))
        return -1;
    return long(elastic.factor.entries());
}

// x = K^-1 b.
long peenSolve(KN<double> *const &b, KN<double> *const &x) {
    const Supernodal &L = elastic.factor;
    ffassert(b->N() == L.n && x->N() == L.n);
    std::vector<float> y(L.n);
    for (int i = 0; i < L.n; ++i) y[L.place[i]] = float((*b)[i]);
    L.down(y.data(), 1, nullptr);
    L.up(y.data(), 1, nullptr);
    for (int i = 0; i < L.n; ++i) (*x)[i] = y[L.place[i]];
    return 0;
}

// The compliance of the contact nodes (their scalar numbers, in an order that keeps neighbours together): every column
// by a pair of solves, many at once.  `modulus` times a length of the mesh, `scale`: C times it is the same for every
// modulus and size.  `file` keeps that ("" does not): it is read when it is there, and one column of it solved again for proof.  Returns 1 when it was read, 0 when it was made, -1 when
// the file is another block's.
long peenCompliance(KN<long> *const &node, const double &scale, string *const &file) {
    const Supernodal &L = elastic.factor;
    std::vector<long> &dof = elastic.contact;
    dof.clear();
    for (long i = 0; i < node->N(); ++i)
        for (int c = 3 - contactComponents; c < 3; ++c) dof.push_back(3 * (*node)[i] + c);
    const size_t m = dof.size();
    std::vector<float> &C = elastic.compliance;
    C.assign(m * m, 0);
    long head[2] = {L.n, long(m)}, found[2] = {0, 0};
    if (!file->empty())
        if (FILE *f = std::fopen(file->c_str(), "rb")) {
            const bool read = std::fread(found, sizeof found, 1, f) == 1 && found[0] == head[0] && found[1] == head[1]
                              && std::fread(C.data(), sizeof(float), m * m, f) == m * m;
            std::fclose(f);
            if (!read) return -1;
            const size_t probe = m / 2;
            std::vector<float> y(L.n, 0.f);
            y[L.place[dof[probe]]] = float(scale);
            L.down(y.data(), 1, nullptr);
            L.up(y.data(), 1, nullptr);
            double off = 0, size = 0;
            for (size_t i = 0; i < m; ++i) {
                const double own = y[L.place[dof[i]]];
                off = std::max(off, std::fabs(own - C[probe * m + i])), size = std::max(size, std::fabs(own));
            }
            if (!(off < 1e-3 * size)) return -1;
            for (float &c : C) c /= float(scale);
            return 1;
        }
    const size_t wide = 96;
    std::vector<float> Y(wide * L.n);
    std::vector<char> below, wanted;
    L.mark(dof.data(), m, wanted);
    for (size_t from = 0; from < m; from += wide) {
        const size_t columns = std::min(wide, m - from);
        std::fill(Y.begin(), Y.end(), 0.f);
        for (size_t c = 0; c < columns; ++c) Y[c * L.n + L.place[dof[from + c]]] = float(scale);
        L.mark(&dof[from], columns, below);
        L.down(Y.data(), int(columns), &below);
        L.up(Y.data(), int(columns), &wanted);
        for (size_t c = 0; c < columns; ++c)
            for (size_t i = 0; i < m; ++i) C[(from + c) * m + i] = Y[c * L.n + L.place[dof[i]]];
    }
    if (!file->empty()) {
        const string part = *file + ".part";
        FILE *f = std::fopen(part.c_str(), "wb");
        ffassert(f);
        const bool written = std::fwrite(head, sizeof head, 1, f) == 1 && std::fwrite(C.data(), sizeof(float), m * m, f) == m * m;
        ffassert(std::fclose(f) == 0 && written);
        ffassert(std::rename(part.c_str(), file->c_str()) == 0);
    }
    for (float &c : C) c /= float(scale);
    return 0;
}

// The columns that `wanted` (number among the unknowns of the contact nodes, anything) still lacks, solved together.
void makeColumns(const std::vector<std::pair<long, float>> &wanted) {
    const Supernodal &L = elastic.factor;
    columns.slot.resize(elastic.contact.size(), -1);
    std::vector<long> fresh, dof;
    for (const auto &w : wanted)
        if (columns.slot[w.first] < 0) fresh.push_back(w.first), dof.push_back(elastic.contact[w.first]);
    const size_t wide = 64;
    std::vector<float> Y(std::min(wide, fresh.size()) * L.n);
    std::vector<char> below;
    for (size_t from = 0; from < fresh.size(); from += wide) {
        const size_t count = std::min(wide, fresh.size() - from);
        std::fill(Y.begin(), Y.end(), 0.f);
        for (size_t c = 0; c < count; ++c) Y[c * L.n + L.place[dof[from + c]]] = 1;
        L.mark(&dof[from], long(count), below);
        L.down(Y.data(), int(count), &below);
        L.up(Y.data(), int(count), &zone.on);
        for (size_t c = 0; c < count; ++c) {
            columns.slot[fresh[from + c]] = int(columns.column.size());
            columns.column.emplace_back(zone.unknown.size());
            for (size_t i = 0; i < zone.unknown.size(); ++i) columns.column.back()[i] = Y[c * L.n + L.place[zone.unknown[i]]];
        }
    }
}

// Brings y up to date with the forces of the last peenPress.
void addLate() {
    const Supernodal &L = elastic.factor;
    std::vector<float> part(L.n, 0.f);
    std::vector<char> on(L.supernodes(), 0);
    for (const auto &f : elastic.late) {
        part[f.first] += f.second;
        L.markPlace(f.first, on);
    }
    elastic.late.clear();
    L.down(part.data(), 1, &on);
    for (int i = 0; i < L.n; ++i) elastic.y[i] += part[i];
}

// One correction of equilibrium and contact, from a whole state f_b = f(U_b) given to peenBase:
//   (30) z = -K^-1 (f_b + q - N lambda);   A lambda' >= A lambda - gap - N^T (U_b + z - U)  (28);
//        step = z + K^-1 N (lambda' - lambda)                                           and the next U is U_b + step
// At its fixed point f_b + K (U - U_b) + q = N lambda and no gap is negative.
//   q: rest (27) of the zone; which: candidates, numbers among the nodes of peenCompliance, all inside the zone;
//   n (3 x candidates): normals out of the sphere; from: U - U_b
// Solved in the factor's own order: down with the zone and up again, then what the forces' change adds: from the columns of
// the nodes that it touches, or, where the zone is the whole block, down with the candidates and up once more, which reads
// most of the factor a second time.  `step` is filled in the zone alone.  Returns the sweeps of the active set, or -1.
long peenPress(KN<double> *const &q, KN<double> *const &from, KN<long> *const &which, KNM<double> *const &n,
               KN<double> *const &gap, KN<double> *const &lambda, KN<double> *const &step) {
    const Supernodal &L = elastic.factor;
    const int m = int(which->N()), all = int(elastic.contact.size()), many = contactComponents, skipped = 3 - many;
    ffassert(q->N() == L.n && step->N() == L.n && from->N() == L.n && n->N() == 3 && n->M() == m && gap->N() == m && lambda->N() == m);
    std::vector<long> dof(many * m); // and normals likewise: components beyond those of the compliance are 0
    std::vector<double> normal(many * m);
    for (int i = 0; i < m; ++i)
        for (int c = 0; c < many; ++c)
            dof[many * i + c] = elastic.contact[many * (*which)[i] + c], normal[many * i + c] = (*n)(long(skipped + c), long(i));
    const bool byColumns = long(zone.unknown.size()) < L.n;
    std::vector<char> on;
    if (!byColumns) L.mark(dof.data(), many * m, on);

    std::vector<float> part(L.n, 0.f);
    for (long i : zone.unknown) part[L.place[i]] = float(-(*q)[i]);
    for (int i = 0; i < many * m; ++i) part[L.place[dof[i]]] += float((*lambda)[i / many] * normal[i]);
    L.down(part.data(), 1, &zone.on);
    elastic.y = elastic.base;
    for (int i = 0; i < L.n; ++i) elastic.y[i] += part[i];
    part = elastic.y;
    L.up(part.data(), 1, byColumns ? &zone.on : &on);

    std::vector<double> A(size_t(m) * m), b(m), force(m);
    for (int i = 0; i < m; ++i)
        for (int j = 0; j <= i; ++j) {
            const float *C = &elastic.compliance[size_t(many * (*which)[i]) * all + many * (*which)[j]];
            double sum = 0;
            for (int c = 0; c < many; ++c)
                for (int d = 0; d < many; ++d) sum += normal[many * i + c] * normal[many * j + d] * C[size_t(c) * all + d];
            A[size_t(i) * m + j] = A[size_t(j) * m + i] = sum;
        }
    for (int i = 0; i < m; ++i) {
        b[i] = -(*gap)[i];
        for (int k = many * i; k < many * (i + 1); ++k) b[i] -= normal[k] * (part[L.place[dof[k]]] - (*from)[dof[k]]);
        for (int j = 0; j < m; ++j) b[i] += A[size_t(i) * m + j] * (*lambda)[j];
        force[i] = (*lambda)[i];
    }
    const int sweeps = contactSet(A, b, force);
    if (sweeps < 0) return -1;

    elastic.late.clear();
    std::vector<std::pair<long, float>> change; // (number among the unknowns of the contact nodes, force)
    for (int i = 0; i < m; ++i) {
        const double more = force[i] - (*lambda)[i];
        for (int k = many * i; k < many * (i + 1) && more != 0; ++k) {
            elastic.late.emplace_back(L.place[dof[k]], float(more * normal[k]));
            change.emplace_back(many * (*which)[i] + k - many * i, float(more * normal[k]));
        }
        (*lambda)[i] = force[i];
    }
    *step = 0.;
    if (byColumns) {
        makeColumns(change);
        std::vector<float> sum(zone.unknown.size());
        for (size_t i = 0; i < sum.size(); ++i) sum[i] = part[L.place[zone.unknown[i]]];
        for (const auto &c : change)
            cblas_saxpy(int(sum.size()), c.second, columns.column[columns.slot[c.first]].data(), 1, sum.data(), 1);
        for (size_t i = 0; i < sum.size(); ++i) (*step)[zone.unknown[i]] = sum[i];
        return sweeps;
    }
    addLate();
    part = elastic.y;
    L.up(part.data(), 1, &zone.on);
    for (long i : zone.unknown) (*step)[i] = part[L.place[i]];
    return sweeps;
}

// f_b of (30).
long peenBase(KN<double> *const &f) {
    const Supernodal &L = elastic.factor;
    ffassert(f->N() == L.n);
    elastic.base.resize(L.n);
    for (int i = 0; i < L.n; ++i) elastic.base[L.place[i]] = float(-(*f)[i]);
    L.down(elastic.base.data(), 1, nullptr);
    return 0;
}

// The step of the last peenPress in the whole block.
long peenSpread(KN<double> *const &step) {
    const Supernodal &L = elastic.factor;
    ffassert(step->N() == L.n && long(elastic.y.size()) == L.n);
    addLate();
    std::vector<float> x = elastic.y;
    L.up(x.data(), 1, nullptr);
    for (int i = 0; i < L.n; ++i) (*step)[i] = x[L.place[i]];
    return 0;
}

} // namespace

#endif
