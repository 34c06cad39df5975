// Rezoning: the mesh let go of the material that it followed, the shape of the surface kept.
//
// Where spheres flatten the ridges between dents, a material that no longer hardens shears on and on in the elements
// there, until they turn inside out.  The kernels need a displacement only for the place of the elements, all they know of
// the past is the state of their points, and that is spatial (Cauchy).  So the displacement is exchanged for
//   (31) u' = (0, 0, h(X, Y) d(Z)),   d(Z) = max(0, 1 + Z/D)^2,      h: height of the deformed surface above (X, Y)
// and each point takes the state of the material that now lies where it is:
//   (32) xi + u(xi) = X + u'(X)      by Newton's method on the old displacement, from element to element
//   (33) state' = sum_q w_q state_q of the element around xi,  w >= 0, sum 1: linear between its Gauss points.  A mean of
//        admissible states is admissible (yield surface convex, isotropic hardening concave in p)
//   (34) a share m of the mean stress of (33) becomes that of the element: what (26) allows it
// Convex means of few neighbours: extremes are lost a little, sums are not kept to the last digit; equilibrium has to be
// found again afterwards.
#ifndef PEEN_BLOCK_REZONE_HPP
#define PEEN_BLOCK_REZONE_HPP

#include "block_forces.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

namespace block {

// Elements node by node and their neighbours, to find points in the undeformed mesh.
class Finder {
  public:
    Finder(const std::vector<int> &node, const std::vector<double> &corner, double period)
        : node(node), corner(corner), period(period), neighbour(node.size() / 10 * 4, -1) {
        std::map<std::array<int, 3>, long> open; // faces met once; a periodic cell closes by its nodes' numbers
        for (long e = 0; e < long(node.size() / 10); ++e)
            for (int k = 0; k < 4; ++k) {
                std::array<int, 3> face;
                for (int n = 0, m = 0; n < 4; ++n)
                    if (n != k) face[m++] = node[10 * e + n];
                std::sort(face.begin(), face.end());
                const auto other = open.find(face);
                if (other == open.end()) { open[face] = 4 * e + k; continue; }
                neighbour[4 * e + k] = int(other->second / 4), neighbour[other->second] = int(e);
                open.erase(other);
            }
    }

    // What the element `e`, walked to from the one handed in, says of the point p: barycentric coordinates, gradients.
    // Beyond the skin: the last element, some l negative.
    void at(long &e, const double *p, double *l, double (*g)[3]) const {
        for (int moves = 0; moves < 1000; ++moves) {
            local(e, p, l, g);
            int worst = -1;
            for (int k = 0; k < 4; ++k)
                if (l[k] < -1e-9 && neighbour[4 * e + k] >= 0 && (worst < 0 || l[k] < l[worst])) worst = k;
            if (worst < 0) return;
            e = neighbour[4 * e + worst];
        }
    }

    // Displacement U and its gradient H at p.
    void displacement(const double *U, long &e, const double *p, double *l, double *u, double *H) const {
        double g[4][3], dN[10][3], un[10][3];
        at(e, p, l, g);
        shapeGradients(g, l, dN);
        for (int i = 0; i < 3; ++i) u[i] = 0;
        for (int n = 0; n < 10; ++n) {
            const double N = n < 4 ? l[n] * (2 * l[n] - 1) : 4 * l[EDGE[n - 4][0]] * l[EDGE[n - 4][1]];
            for (int i = 0; i < 3; ++i) un[n][i] = U[3 * node[10 * e + n] + i], u[i] += N * un[n][i];
        }
        gather(dN, un, H);
    }

    // (32): xi, started where it is handed in, in element e; dims 2: along the surface alone, then target[2] is not used.
    // Returns what is left of the distance.
    double invert(const double *U, const double *target, int dims, long &e, double *xi, double *l, double *u) const {
        double H[9], c[9], left = off(U, target, dims, e, xi, l, u, H);
        for (int it = 0; it < 60 && left > 1e-9; ++it) {
            double F[9] = {1 + H[0], H[1], H[2], H[3], 1 + H[4], H[5], H[6], H[7], 1 + H[8]}, r[3], step[3];
            if (dims == 2) F[2] = F[5] = F[6] = F[7] = 0, F[8] = 1;
            const double det = cofactors(F, c);
            for (int i = 0; i < 3; ++i) r[i] = i < dims ? target[i] - xi[i] - u[i] : 0;
            for (int j = 0; j < 3; ++j) // an element inside out leads the wrong way: plain iteration there
                step[j] = det > 0.05 ? (c[j] * r[0] + c[3 + j] * r[1] + c[6 + j] * r[2]) / det : r[j];
            bool nearer = false;
            for (double t = 1; t > 0.01 && !nearer; t *= 0.5) {
                double there[3], uThere[3], HThere[9], lThere[4];
                long eThere = e;
                for (int i = 0; i < 3; ++i) there[i] = xi[i] + t * step[i];
                const double d = off(U, target, dims, eThere, there, lThere, uThere, HThere);
                if (!(d < left)) continue;
                nearer = true;
                left = d;
                e = eThere;
                std::copy(there, there + 3, xi), std::copy(uThere, uThere + 3, u);
                std::copy(HThere, HThere + 9, H), std::copy(lThere, lThere + 4, l);
            }
            if (!nearer) break;
        }
        return left;
    }

  private:
    const std::vector<int> &node;
    const std::vector<double> &corner;
    const double period;
    std::vector<int> neighbour; // over the face opposite vertex k; -1: the skin

    void local(long e, const double *p, double *l, double (*g)[3]) const {
        const double(*x)[3] = reinterpret_cast<const double(*)[3]>(&corner[12 * e]);
        barycentric(x, g);
        double d[3];
        for (int i = 0; i < 3; ++i) {
            d[i] = p[i] - x[0][i];
            if (period > 0 && i < 2) // the image nearest to the element's middle
                d[i] -= period * std::round((p[i] - 0.25 * (x[0][i] + x[1][i] + x[2][i] + x[3][i])) / period);
        }
        for (int k = 0; k < 4; ++k) l[k] = (k == 0) + g[k][0] * d[0] + g[k][1] * d[1] + g[k][2] * d[2];
    }

    double off(const double *U, const double *target, int dims, long &e, const double *xi, double *l, double *u, double *H) const {
        displacement(U, e, xi, l, u, H);
        double sum = 0;
        for (int i = 0; i < dims; ++i) sum += (xi[i] + u[i] - target[i]) * (xi[i] + u[i] - target[i]);
        return std::sqrt(sum);
    }
};

// (33): the state at barycentric coordinates l of an element whose four states are `four`.
inline void interpolate(const double *four, const double *l, double *state) {
    double w[4], sum = 0;
    for (int q = 0; q < 4; ++q) sum += w[q] = std::max(0., (l[q] - FAR) / (NEAR - FAR));
    for (int i = 0; i < STATE; ++i) {
        state[i] = 0;
        for (int q = 0; q < 4; ++q) state[i] += w[q] / sum * four[STATE * q + i];
    }
}

} // namespace block

#endif
