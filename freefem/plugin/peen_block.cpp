// Kernels of the contact model (freefem/contact.edp): a block of P2 tetrahedra at finite strain under rigid spheres.
// ff-c++: -lcholmod -lopenblas
//
// Vectors of unknowns hold 3 node + component.  The Gauss points' equations (21)-(24) stand in block_point.hpp, the
// elements' (25)-(27) in block_forces.hpp, (28) in contact_set.hpp, (29) in anderson.hpp.

#include "ff++.hpp"
#include "AFunction_ext.hpp"
#include "anderson.hpp"
#include "block_checkpoint.hpp"
#include "block_forces.hpp"
#include "block_press.hpp"
#include "block_rezone.hpp"

namespace {

struct Mesh {
    long unknowns = 0;
    bool finite = true;         // strain
    double period = 0;          // of a periodic cell
    std::vector<int> node;      // ten an element
    std::vector<double> corner; // twelve an element
};
Mesh mesh; // one block a run
Anderson anderson;

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
    contactComponents = mesh.finite ? 3 : 1;
    mesh.period = period;
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
    const bool whole = long(zone.unknown.size()) == mesh.unknowns; // has no columns: those of the last zone are kept
    if (!whole && (columns.x != x || columns.y != y || columns.reach != reach)) {
        columns = Columns();
        columns.x = x, columns.y = y, columns.reach = reach;
    }
    return long(zone.element.size());
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

// How far the elements are from the shape they were made in: the smallest det F at a vertex, where P2 turns inside out
// first.  (Vertices: the Gauss points may still be well when their element has folded.)
double peenShape(KN<double> *const &U) {
    ffassert(U->N() == mesh.unknowns);
    double least = 1e30;
    for (size_t e = 0; e < mesh.node.size() / 10; ++e) {
        double g[4][3], dN[10][3], u[10][3], F[9], c[9];
        block::barycentric(reinterpret_cast<const double(*)[3]>(&mesh.corner[12 * e]), g);
        for (int n = 0; n < 10; ++n)
            for (int i = 0; i < 3; ++i) u[n][i] = (*U)[3 * mesh.node[10 * e + n] + i];
        for (int v = 0; v < 4; ++v) {
            double l[4] = {0, 0, 0, 0};
            l[v] = 1;
            block::shapeGradients(g, l, dN);
            block::gather(dN, u, F);
            for (int i = 0; i < 9; i += 4) F[i] += 1;
            least = std::min(least, block::cofactors(F, c));
        }
    }
    return least;
}

// Rezoning, (31)-(34): U and the states are exchanged; depth D of (31), share m of (34).
// Returns the largest distance (mm) between a point and the material it was given: 0 but for an old mesh that folded.
double peenRezone(KNM<double> *const &place, KN<double> *const &U, KNM<double> *const &state, const double &depth, const double &share) {
    const long elements = long(mesh.node.size() / 10), nodes = mesh.unknowns / 3;
    ffassert(U->N() == mesh.unknowns && place->M() == nodes && state->N() == block::STATE && state->M() == 4 * elements);
    const block::Finder finder(mesh.node, mesh.corner, mesh.period);
    const std::vector<double> old(&(*U)[0], &(*U)[0] + mesh.unknowns);
    std::vector<long> home(nodes, -1);
    for (long e = 0; e < elements; ++e)
        for (int n = 0; n < 10; ++n) home[mesh.node[10 * e + n]] = e;
    double worst = 0;
    for (long i = 0; i < nodes; ++i) {
        const double target[3] = {(*place)(0L, i), (*place)(1L, i), 0}, d = 1 + (*place)(2L, i) / depth;
        double xi[3] = {target[0], target[1], 0}, l[4], u[3] = {0, 0, 0};
        long e = home[i];
        if (d > 0) worst = std::max(worst, finder.invert(old.data(), target, 2, e, xi, l, u));
        (*U)[3 * i] = (*U)[3 * i + 1] = 0;
        (*U)[3 * i + 2] = d > 0 ? u[2] * d * d : 0;
    }
    std::vector<double> now(size_t(block::STATE) * 4 * elements);
    for (long e = 0; e < elements; ++e) {
        double lq[4], u[3], H[9], pressure[4], mean = 0;
        for (int q = 0; q < 4; ++q) {
            double p[3] = {0, 0, 0}, target[3], xi[3];
            for (int n = 0; n < 4; ++n)
                for (int i = 0; i < 3; ++i) p[i] += (n == q ? block::NEAR : block::FAR) * mesh.corner[12 * e + 3 * n + i];
            long at = e;
            finder.displacement(&(*U)[0], at, p, lq, u, H);
            for (int i = 0; i < 3; ++i) xi[i] = p[i], target[i] = p[i] + u[i];
            at = e;
            worst = std::max(worst, finder.invert(old.data(), target, 3, at, xi, lq, u));
            double *s = &now[size_t(block::STATE) * (4 * e + q)];
            block::interpolate(&(*state)(0L, 4 * at), lq, s);
            mean += 0.25 * (pressure[q] = (s[0] + s[1] + s[2]) / 3);
        }
        for (int q = 0; q < 4; ++q)
            for (int i = 0; i < 3; ++i) now[size_t(block::STATE) * (4 * e + q) + i] += share * (mean - pressure[q]);
    }
    for (long k = 0; k < 4 * elements; ++k)
        for (long i = 0; i < block::STATE; ++i) (*state)(i, k) = now[size_t(block::STATE) * k + i];
    return worst;
}

// (29): U becomes the next iterate, g = G(U).  depth 0 forgets.
long peenAnderson(const long &depth, KN<double> *const &U, KN<double> *const &g) {
    if (depth == 0) { anderson.reset(); return 0; }
    ffassert(U->N() == g->N());
    anderson.step(int(depth), U->N(), &(*U)[0], &(*g)[0]);
    return 0;
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
    Global.Add("peenShape", "(", new OneOperator1_<double, Vector>(peenShape));
    Global.Add("peenRezone", "(", new OneOperator5_<double, Table, Vector, Table, double, double>(peenRezone));
    Global.Add("peenAnderson", "(", new OneOperator3_<long, long, Vector, Vector>(peenAnderson));
}

} // namespace

LOADFUNC(init)
