// Kernels of the contact model (freefem/contact.edp): a block of P2 tetrahedra at finite strain under rigid spheres.
// ff-c++: -lcholmod -lopenblas
//
// Vectors of unknowns hold 3 node + component.  The Gauss points' equations (21)-(24) stand in block_point.hpp, the
// elements' (25)-(27) in block_forces.hpp, (28) in contact_set.hpp, (29) in anderson.hpp.

#include "ff++.hpp"
#include "AFunction_ext.hpp"
#include "anderson.hpp"
#include "block_forces.hpp"
#include "supernodal.hpp"

#include <cstdio>

namespace {

struct Elastic {
    Supernodal factor;
    std::vector<long> contact;     // unknowns of the contact nodes: 3 candidate + component
    std::vector<float> compliance; // of these, square
    std::vector<float> base, y;    // L^-1 of the right-hand sides of peenBase and of the last peenPress
};
struct Mesh {
    long unknowns = 0;
    bool finite = true;         // strain
    std::vector<int> node;      // ten an element
    std::vector<double> corner; // twelve an element
};
struct Zone {
    std::vector<long> element, unknown, skin; // skin: unknowns of nodes that elements outside share
    std::vector<char> on;                     // supernodes of its unknowns and their ancestors
};
Mesh mesh; // one block a run
Zone zone;
Elastic elastic;
Anderson anderson;
const long CHECKPOINT = 0x7065656e0001; // first number of the file: its format

// The mesh of all that follows: nodes (10 x elements), corners (12 x elements: x, y, z of an element's four), place
// (3 x nodes), period: of a cell that repeats along x and y, 0 for none, finite: strain (0: small).  Fills points (4 x 4 elements): x, y, z and
// volume of the Gauss points.  Stops when a node is not where a straight P2 element has it or an element is inside out:
// the mesh is then not what these kernels think it is.
long peenMesh(KNM<long> *const &nodes, KNM<double> *const &corners, KNM<double> *const &place, const double &period,
              const long &finite, KNM<double> *const &points) {
    const long elements = nodes->M();
    ffassert(nodes->N() == 10 && corners->N() == 12 && corners->M() == elements);
    ffassert(place->N() == 3 && points->N() == 4 && points->M() == 4 * elements);
    mesh.node.resize(10 * elements);
    mesh.corner.resize(12 * elements);
    mesh.unknowns = 3 * place->M();
    mesh.finite = finite != 0;
    for (long e = 0; e < elements; ++e) {
        double x[10][3], g[4][3];
        for (int n = 0; n < 4; ++n)
            for (int i = 0; i < 3; ++i) mesh.corner[12 * e + 3 * n + i] = x[n][i] = (*corners)(3L * n + i, e);
        for (int k = 0; k < 6; ++k)
            for (int i = 0; i < 3; ++i) x[4 + k][i] = 0.5 * (x[block::EDGE[k][0]][i] + x[block::EDGE[k][1]][i]);
        const double volume = block::barycentric(x, g);
        ffassert(volume > 0);
        for (long n = 0; n < 10; ++n) {
            mesh.node[10 * e + n] = int((*nodes)(n, e));
            for (long i = 0; i < 3; ++i) {
                double off = (*place)(i, (*nodes)(n, e)) - x[n][i];
                if (period > 0 && i < 2) off -= period * std::round(off / period);
                ffassert(std::fabs(off) < 1e-9);
            }
        }
        for (long q = 0; q < 4; ++q) {
            for (long i = 0; i < 3; ++i) {
                double sum = 0;
                for (int n = 0; n < 4; ++n) sum += (n == q ? block::NEAR : block::FAR) * x[n][i];
                (*points)(i, 4 * e + q) = sum;
            }
            (*points)(3L, 4 * e + q) = 0.25 * volume;
        }
    }
    return 0;
}

// Adds element e's forces to f, and its rest (27) to q when that is wanted.  Returns the number of points that failed.
long addElement(const Law &law, double share, long e, const KN<double> &Uold, const KN<double> &U, KNM<double> &stateOld,
                KNM<double> &stateNew, double *f, double *q) {
    const int *node = &mesh.node[10 * e];
    double uo[10][3], u[10][3], force[10][3], rest[10][3];
    for (int n = 0; n < 10; ++n)
        for (int i = 0; i < 3; ++i) uo[n][i] = Uold[3 * node[n] + i], u[n][i] = U[3 * node[n] + i];
    const long failed = block::element(law, share, mesh.finite, reinterpret_cast<const double(*)[3]>(&mesh.corner[12 * e]), uo, u,
                                       &stateOld(0L, 4 * e), &stateNew(0L, 4 * e), force, q ? rest : nullptr);
    for (int n = 0; n < 10; ++n)
        for (int i = 0; i < 3; ++i) {
            f[3 * node[n] + i] += force[n][i];
            if (q) q[3 * node[n] + i] += rest[n][i];
        }
    return failed;
}

Law checkedLaw(KN<double> *const &lawArray, KN<double> *Uold, KN<double> *U, KNM<double> *stateOld, KNM<double> *stateNew) {
    ffassert(Law::complete(*lawArray));
    const long points = 4 * long(mesh.node.size() / 10);
    ffassert(U->N() == mesh.unknowns && Uold->N() == mesh.unknowns);
    ffassert(stateOld->N() == block::STATE && stateNew->N() == block::STATE && stateOld->M() == points && stateNew->M() == points);
    Law law(*lawArray);
    law.heat = 0;
    return law;
}

// Internal forces at U (25), (26) and the new states of the points, from the converged step before (Uold, stateOld).
//   law: as in hardening.hpp, no rate and no heat; share: m of (26), 0 to 1; states (19 x 4 elements)
// Returns the number of points that failed (turned inside out, or without a root); f is then not to be used.
long peenBlock(KN<double> *const &lawArray, const double &share, KN<double> *const &Uold, KN<double> *const &U,
               KNM<double> *const &stateOld, KNM<double> *const &stateNew, KN<double> *const &f) {
    const Law law = checkedLaw(lawArray, Uold, U, stateOld, stateNew);
    ffassert(f->N() == mesh.unknowns);
    *f = 0.;
    long failed = 0;
    for (long e = 0; e < long(mesh.node.size() / 10); ++e)
        failed += addElement(law, share, e, *Uold, *U, *stateOld, *stateNew, &(*f)[0], nullptr);
    return failed;
}

// The same for the elements of the zone alone, with the rest q (27).  f holds the whole force at nodes inside the zone;
// elsewhere f and q are 0 or, at the nodes of its skin, the zone's part.
long peenZoneForces(KN<double> *const &lawArray, const double &share, KN<double> *const &Uold, KN<double> *const &U,
                    KNM<double> *const &stateOld, KNM<double> *const &stateNew, KN<double> *const &f, KN<double> *const &q) {
    const Law law = checkedLaw(lawArray, Uold, U, stateOld, stateNew);
    ffassert(f->N() == mesh.unknowns && q->N() == mesh.unknowns);
    *f = 0.;
    *q = 0.;
    long failed = 0;
    for (long e : zone.element)
        failed += addElement(law, share, e, *Uold, *U, *stateOld, *stateNew, &(*f)[0], &(*q)[0]);
    for (long i : zone.skin) (*f)[i] = 0;
    return failed;
}

// The zone: the elements whose middle lies within `reach` of (x, y, 0).  Outside of it an impact's steps take the block
// as elastic, with the stiffness K; what that leaves is seen by the next whole evaluation and mended by the next step.
// Returns the number of its elements.
long peenZone(const double &x, const double &y, const double &reach, const double &period) {
    const long elements = long(mesh.node.size() / 10);
    std::vector<char> inside(mesh.unknowns / 3, 0), outside(mesh.unknowns / 3, 0);
    zone = Zone();
    for (long e = 0; e < elements; ++e) {
        double m[3] = {-x, -y, 0};
        for (int n = 0; n < 4; ++n)
            for (int i = 0; i < 3; ++i) m[i] += 0.25 * mesh.corner[12 * e + 3 * n + i];
        for (int i = 0; i < 2 && period > 0; ++i) m[i] -= period * std::round(m[i] / period);
        const bool in = m[0] * m[0] + m[1] * m[1] + m[2] * m[2] < reach * reach;
        if (in) zone.element.push_back(e);
        for (int n = 0; n < 10; ++n) (in ? inside : outside)[mesh.node[10 * e + n]] = 1;
    }
    for (long n = 0; n < mesh.unknowns / 3; ++n)
        for (int i = 0; i < 3 && inside[n]; ++i) {
            zone.unknown.push_back(3 * n + i);
            if (outside[n]) zone.skin.push_back(3 * n + i);
        }
    elastic.factor.mark(zone.unknown.data(), long(zone.unknown.size()), zone.on);
    return long(zone.element.size());
}

// The one factorisation: K by its triplets (both triangles or the lower one), unknowns with fixed > 0 taken out.
// Returns the number of entries of the factor, or -1: K is not positive definite.
long peenFactor(KN<long> *const &row, KN<long> *const &col, KN<double> *const &value, KN<double> *const &fixed) {
    ffassert(row->N() == value->N() && col->N() == value->N());
    elastic = Elastic();
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
// by a pair of solves, many at once.  `modulus` E: E C does not depend on E.  `file` keeps it ("" does not): it is read
// when it is there, and one column of it solved again for proof.  Returns 1 when it was read, 0 when it was made, -1 when
// the file is another block's.
long peenCompliance(KN<long> *const &node, const double &modulus, string *const &file) {
    const Supernodal &L = elastic.factor;
    std::vector<long> &dof = elastic.contact;
    dof.clear();
    for (long i = 0; i < node->N(); ++i)
        for (int c = 0; c < 3; ++c) dof.push_back(3 * (*node)[i] + c);
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
            y[L.place[dof[probe]]] = float(modulus);
            L.down(y.data(), 1, nullptr);
            L.up(y.data(), 1, nullptr);
            double off = 0, size = 0;
            for (size_t i = 0; i < m; ++i) {
                const double own = y[L.place[dof[i]]];
                off = std::max(off, std::fabs(own - C[probe * m + i])), size = std::max(size, std::fabs(own));
            }
            if (!(off < 1e-3 * size)) return -1;
            for (float &c : C) c /= float(modulus);
            return 1;
        }
    const size_t wide = 96;
    std::vector<float> Y(wide * L.n);
    std::vector<char> below, wanted;
    L.mark(dof.data(), m, wanted);
    for (size_t from = 0; from < m; from += wide) {
        const size_t columns = std::min(wide, m - from);
        std::fill(Y.begin(), Y.end(), 0.f);
        for (size_t c = 0; c < columns; ++c) Y[c * L.n + L.place[dof[from + c]]] = float(modulus);
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
    for (float &c : C) c /= float(modulus);
    return 0;
}

// Gap and normal (out of the sphere, 3 x candidates) of each candidate, their first unknowns in `dof`, at U.
//   sphere: x, y, z of its centre, radius, period, then the edges x0, x1, y0, y1 of where contact is believed
// Small strain: straight down on the undeformed surface, as the forces then are on the undeformed block.
// Fills found: largest distance of a node in contact from the sphere's axis, vertical force, distance to the edges.
long peenTouch(KN<double> *const &sphere, KNM<double> *const &place, KN<double> *const &U, KN<long> *const &dof,
               KN<double> *const &lambda, KNM<double> *const &normal, KN<double> *const &gap, KN<double> *const &found) {
    const KN<double> &s = *sphere;
    const double R = s[3], period = s[4];
    ffassert(s.N() == 9 && found->N() == 3 && gap->N() == dof->N() && normal->M() == dof->N());
    double far = 0, force = 0, edge = 1e30;
    for (long k = 0; k < dof->N(); ++k) {
        const long i = (*dof)[k] / 3;
        double p[3];
        for (long c = 0; c < 3; ++c) {
            p[c] = (*place)(c, i) - s[c];
            if (mesh.finite || c == 2) p[c] += (*U)[3 * i + c];
            if (period > 0 && c < 2) p[c] -= period * std::round(p[c] / period);
        }
        const double across = p[0] * p[0] + p[1] * p[1], length = std::sqrt(across + p[2] * p[2]);
        if (mesh.finite) {
            (*gap)[k] = length - R;
            for (long c = 0; c < 3; ++c) (*normal)(c, k) = p[c] / length;
        } else {
            (*gap)[k] = -std::sqrt(std::max(R * R - across, 0.02 * R * R)) - p[2];
            (*normal)(0L, k) = (*normal)(1L, k) = 0, (*normal)(2L, k) = -1;
        }
        force -= (*lambda)[k] * (*normal)(2L, k);
        if (!((*lambda)[k] > 0)) continue;
        far = std::max(far, std::sqrt(across));
        const double x = (*place)(0L, i), y = (*place)(1L, i);
        edge = std::min(edge, std::min(std::min(x - s[5], s[6] - x), std::min(y - s[7], s[8] - y)));
    }
    (*found)[0] = far, (*found)[1] = force, (*found)[2] = edge;
    return 0;
}

// One correction of equilibrium and contact, from a whole state f_b = f(U_b) given to peenBase:
//   (30) z = -K^-1 (f_b + q - N lambda);   A lambda' >= A lambda - gap - N^T (U_b + z - U)  (28);
//        step = z + K^-1 N (lambda' - lambda)                                           and the next U is U_b + step
// At its fixed point f_b + K (U - U_b) + q = N lambda and no gap is negative.
//   q: rest (27) of the zone; which: candidates, numbers among the nodes of peenCompliance, all inside the zone;
//   n (3 x candidates): normals out of the sphere; from: U - U_b
// Solved in the factor's own order: down with the zone, up and down again with what belongs to the candidates, up with
// the zone, where alone `step` is filled.  Returns the sweeps of the active set, or -1.
long peenPress(KN<double> *const &q, KN<double> *const &from, KN<long> *const &which, KNM<double> *const &n,
               KN<double> *const &gap, KN<double> *const &lambda, KN<double> *const &step) {
    const Supernodal &L = elastic.factor;
    const int m = int(which->N()), all = int(elastic.contact.size());
    ffassert(q->N() == L.n && step->N() == L.n && from->N() == L.n && n->N() == 3 && n->M() == m && gap->N() == m && lambda->N() == m);
    std::vector<long> dof(3 * m);
    for (int i = 0; i < m; ++i)
        for (int c = 0; c < 3; ++c) dof[3 * i + c] = elastic.contact[3 * (*which)[i] + c];
    std::vector<char> on;
    L.mark(dof.data(), 3 * m, on);

    std::vector<float> part(L.n, 0.f);
    for (long i : zone.unknown) part[L.place[i]] = float(-(*q)[i]);
    for (int i = 0; i < m; ++i)
        for (int c = 0; c < 3; ++c) part[L.place[dof[3 * i + c]]] += float((*lambda)[i] * (*n)(c, i));
    L.down(part.data(), 1, &zone.on);
    elastic.y = elastic.base;
    for (int i = 0; i < L.n; ++i) elastic.y[i] += part[i];
    part = elastic.y;
    L.up(part.data(), 1, &on);

    std::vector<double> A(size_t(m) * m), b(m), force(m);
    for (int i = 0; i < m; ++i)
        for (int j = 0; j <= i; ++j) {
            const float *C = &elastic.compliance[size_t(3 * (*which)[i]) * all + 3 * (*which)[j]];
            double sum = 0;
            for (int c = 0; c < 3; ++c)
                for (int d = 0; d < 3; ++d) sum += (*n)(c, i) * (*n)(d, j) * C[size_t(c) * all + d];
            A[size_t(i) * m + j] = A[size_t(j) * m + i] = sum;
        }
    for (int i = 0; i < m; ++i) {
        b[i] = -(*gap)[i];
        for (int c = 0; c < 3; ++c) b[i] -= (*n)(c, i) * (part[L.place[dof[3 * i + c]]] - (*from)[dof[3 * i + c]]);
        for (int j = 0; j < m; ++j) b[i] += A[size_t(i) * m + j] * (*lambda)[j];
        force[i] = (*lambda)[i];
    }
    const int sweeps = contactSet(A, b, force);
    if (sweeps < 0) return -1;

    std::fill(part.begin(), part.end(), 0.f);
    for (int i = 0; i < m; ++i) {
        for (int c = 0; c < 3; ++c) part[L.place[dof[3 * i + c]]] = float((force[i] - (*lambda)[i]) * (*n)(c, i));
        (*lambda)[i] = force[i];
    }
    L.down(part.data(), 1, &on);
    for (int i = 0; i < L.n; ++i) elastic.y[i] += part[i];
    part = elastic.y;
    L.up(part.data(), 1, &zone.on);
    *step = 0.;
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
    std::vector<float> x = elastic.y;
    L.up(x.data(), 1, nullptr);
    for (int i = 0; i < L.n; ++i) (*step)[i] = x[L.place[i]];
    return 0;
}

// (29): U becomes the next iterate, g = G(U).  depth 0 forgets.
long peenAnderson(const long &depth, KN<double> *const &U, KN<double> *const &g) {
    if (depth == 0) { anderson.reset(); return 0; }
    ffassert(U->N() == g->N());
    anderson.step(int(depth), U->N(), &(*U)[0], &(*g)[0]);
    return 0;
}

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

void init() {
    typedef KN<double> *Vector;
    typedef KN<long> *Index;
    typedef KNM<double> *Table;
    Global.Add("peenMesh", "(", new OneOperator6_<long, KNM<long> *, Table, Table, double, long, Table>(peenMesh));
    Global.Add("peenBlock", "(", new OneOperator7_<long, Vector, double, Vector, Vector, Table, Table, Vector>(peenBlock));
    Global.Add("peenFactor", "(", new OneOperator4_<long, Index, Index, Vector, Vector>(peenFactor));
    Global.Add("peenSolve", "(", new OneOperator2_<long, Vector, Vector>(peenSolve));
    Global.Add("peenCompliance", "(", new OneOperator3_<long, Index, double, string *>(peenCompliance));
    Global.Add("peenZone", "(", new OneOperator4_<long, double, double, double, double>(peenZone));
    Global.Add("peenZoneForces", "(",
               new OneOperator8_<long, Vector, double, Vector, Vector, Table, Table, Vector, Vector>(peenZoneForces));
    Global.Add("peenBase", "(", new OneOperator1_<long, Vector>(peenBase));
    Global.Add("peenTouch", "(", new OneOperator8_<long, Vector, Table, Vector, Index, Vector, Table, Vector, Vector>(peenTouch));
    Global.Add("peenPress", "(", new OneOperator7_<long, Vector, Vector, Index, Table, Vector, Vector, Vector>(peenPress));
    Global.Add("peenSpread", "(", new OneOperator1_<long, Vector>(peenSpread));
    Global.Add("peenWrite", "(", new OneOperator5_<long, string *, Vector, Vector, Table, Table>(peenWrite));
    Global.Add("peenRead", "(", new OneOperator5_<long, string *, Vector, Vector, Table, Table>(peenRead));
    Global.Add("peenAnderson", "(", new OneOperator3_<long, long, Vector, Vector>(peenAnderson));
}

} // namespace

LOADFUNC(init)
