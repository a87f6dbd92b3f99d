// Gauss-Legendre quadrature on [a, b], in double precision: the oracle's integrator.
#pragma once

#include <cmath>
#include <vector>

namespace lumisweep::test {

struct GaussLegendre {
    std::vector<double> node, weight; ///< on [0, 1]

    /// Newton's method on the Legendre polynomial from Chebyshev's guesses.
    explicit GaussLegendre(int n) : node(static_cast<std::size_t>(n)), weight(static_cast<std::size_t>(n))
    {
        for (int i = 0; i < n; ++i) {
            double x = std::cos(3.14159265358979323846 * (i + 0.75) / (n + 0.5)), derivative = 1.0;
            for (int step = 0; step < 50; ++step) {
                double p0 = 1.0, p1 = x;
                for (int k = 2; k <= n; ++k) {
                    const double p2 = ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k;
                    p0 = p1;
                    p1 = p2;
                }
                derivative = n * (x * p1 - p0) / (x * x - 1.0);
                const double dx = p1 / derivative;
                x -= dx;
                if (std::fabs(dx) < 1e-15)
                    break;
            }
            node[static_cast<std::size_t>(i)] = 0.5 * (1.0 - x);
            weight[static_cast<std::size_t>(i)] = 1.0 / ((1.0 - x * x) * derivative * derivative);
        }
    }

    template <class Function>
    double operator()(double a, double b, Function&& f) const
    {
        double sum = 0.0;
        for (std::size_t i = 0; i < node.size(); ++i)
            sum += weight[i] * f(a + (b - a) * node[i]);
        return sum * (b - a);
    }
};

} // namespace lumisweep::test
