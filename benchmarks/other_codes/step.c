/* The time step of dem.motion.kernels written in C: what a compiled loop can reach.
 *
 * Linear springs, friction with a spring of its own, drag, pressure control; the list of pairs is
 * given and long enough for all steps.  Plain doubles, one thread, the order of the pairs as given.
 */
#include <math.h>
#include <stdint.h>

static double forces(int64_t c, const double *restrict z, const double *restrict v,
                     const double *restrict s, double scale, const uint32_t *restrict i,
                     const uint32_t *restrict j, const double *restrict shift,
                     const double *restrict sigma, double *restrict u, double k, double kt,
                     double mu, double dt, double *restrict pull, double *restrict twist)
{
    double virial = 0.0, compliance = 1.0 / kt;
    for (int64_t e = 0; e < c; e++) {
        uint32_t a = i[e], b = j[e];
        double dx = z[2 * b] - z[2 * a] + shift[2 * e] * scale;
        double dy = z[2 * b + 1] - z[2 * a + 1] + shift[2 * e + 1] * scale;
        double r2 = dx * dx + dy * dy;
        if (r2 >= sigma[e] * sigma[e]) {
            u[e] = 0.0;
            continue;
        }
        double r = sqrt(r2), inverse = 1.0 / r, nx = dx * inverse, ny = dy * inverse;
        double normal = k * (sigma[e] - r), cap = mu * normal;
        double vx = v[2 * b] - v[2 * a], vy = v[2 * b + 1] - v[2 * a + 1];
        double along = vx * nx + vy * ny, across = vy * nx - vx * ny;
        double slip = across / (1.0 - 0.5 * dt * along * inverse) - (s[a] + s[b]);
        double tangential = kt * (u[e] + dt * slip);
        tangential = tangential < -cap ? -cap : tangential > cap ? cap : tangential;
        u[e] = tangential * compliance;
        twist[a] += tangential;
        twist[b] += tangential;
        double fx = -normal * nx - tangential * ny, fy = tangential * nx - normal * ny;
        pull[2 * a] += fx;
        pull[2 * a + 1] += fy;
        pull[2 * b] -= fx;
        pull[2 * b + 1] -= fy;
        virial += normal * r;
    }
    return virial;
}

/* ``steps`` whole steps of N grains and c pairs; ``cell``: scale and strain rate, in and out. */
void advance(int64_t N, int64_t c, double *restrict z, double *restrict v, double *restrict s,
             const double *restrict per_mass, double total, double area, const uint32_t *restrict i,
             const uint32_t *restrict j, const double *restrict shift, const double *restrict sigma,
             double *restrict u, const double *restrict origin, double k, double kt, double mu,
             double drag, double pressure, double dt, int64_t steps, double *restrict pull,
             double *restrict twist, double *restrict cell, double *restrict farthest)
{
    double scale = cell[0], rate = cell[1], far = 0.0;
    double fade = (1.0 - 0.5 * drag * dt) / (1.0 + 0.5 * drag * dt), gain = dt / (1.0 + 0.5 * drag * dt);
    for (int64_t done = 0; done < steps; done++) {
        double grow = 1.0 + rate * dt;
        scale *= grow;
        for (int64_t g = 0; g < N; g++) {
            z[2 * g] = z[2 * g] * grow + v[2 * g] * dt;
            z[2 * g + 1] = z[2 * g + 1] * grow + v[2 * g + 1] * dt;
            double wx = z[2 * g] - scale * origin[2 * g], wy = z[2 * g + 1] - scale * origin[2 * g + 1];
            double w2 = wx * wx + wy * wy;
            far = w2 > far ? w2 : far;
            pull[2 * g] = pull[2 * g + 1] = twist[g] = 0.0;
        }
        double virial = forces(c, z, v, s, scale, i, j, shift, sigma, u, k, kt, mu, dt, pull, twist);
        for (int64_t g = 0; g < N; g++) {
            double push = gain * per_mass[g];
            v[2 * g] = v[2 * g] * fade + push * pull[2 * g];
            v[2 * g + 1] = v[2 * g + 1] * fade + push * pull[2 * g + 1];
            s[g] = s[g] * fade + 2.0 * push * twist[g];
        }
        rate = fade * rate + gain * (virial - 2.0 * pressure * area * scale * scale) / total;
    }
    cell[0] = scale;
    cell[1] = rate;
    farthest[0] = far;
}
