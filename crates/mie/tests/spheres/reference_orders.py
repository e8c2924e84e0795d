"""Reference values of Debye orders at raindrop size and with absorption, in arbitrary precision.

pip install mpmath gmpy2
python reference_orders.py > order_references.rs

A second way to the Debye series, which shares nothing with `reference.py` or the crate but the
definition: each partial wave meets the surface from outside and from inside, the two continuity
conditions of each are solved as a linear system, and an order is the product along its path. The
waves are h_n of both kinds by recurrence, checked against their closed finite sum; pi_n and tau_n
come from Legendre polynomials.
"""
import mpmath as mp

ANGLES_DEG = [10.0, 60.0, 100.0, 128.0, 129.5, 137.0, 138.3, 145.0, 170.0]
CASES = [(5000.0, 1.333, 0.0, (0, 2, 3, 6)), (200.0, 1.33, 0.002, tuple(range(8))), (5000.0, 1.33, 1e-5, (2, 3))]


def n_terms(x):
    return int(x + 8 * x ** (1 / 3) + 24)


def digits(x, m):
    """The incoming wave inside decays towards the turning point as exp(-2 Im(mx))."""
    return 50 + int(abs(m.imag) * x)


def riccati_hankel(z, n_max, sign):
    """z h_n and its derivative for outgoing (sign 1) and incoming waves (-1), n = 0..n_max."""
    i = mp.mpc(0, sign)
    waves = [-i * mp.exp(i * z), -mp.exp(i * z) * (1 + i / z)]
    for n in range(1, n_max):
        waves.append((2 * n + 1) / z * waves[n] - waves[n - 1])
    for n in (1, 7, min(60, n_max)):
        check(waves[n], z, n, i)
    derivatives = [i * waves[0]] + [waves[n - 1] - n * waves[n] / z for n in range(1, n_max + 1)]
    return waves, derivatives


def check(wave, z, n, i):
    """z h_n = (-i)^(n+1) exp(iz) sum_k (n+k)!/(k! (n-k)!) (i/(2z))^k."""
    total = mp.fsum(mp.factorial(n + k) / (mp.factorial(k) * mp.factorial(n - k)) * (i / (2 * z)) ** k
                    for k in range(n + 1))
    closed = (-i) ** (n + 1) * mp.exp(i * z) * total
    assert abs(wave - closed) < mp.mpf(10) ** (-30) * abs(closed), n


def solve(a, b, right):
    """The two unknowns of unknown_1 a + unknown_2 b = right, each a pair of conditions."""
    determinant = a[0] * b[1] - a[1] * b[0]
    return ((right[0] * b[1] - right[1] * b[0]) / determinant,
            (a[0] * right[1] - a[1] * right[0]) / determinant)


def passages(x, m):
    """For electric and magnetic waves: reflection outside, in, reflection inside, out."""
    n_max = n_terms(x)
    out_x, in_x = (riccati_hankel(x, n_max, sign) for sign in (1, -1))
    out_y, in_y = (riccati_hankel(m * x, n_max, sign) for sign in (1, -1))
    for is_electric in (True, False):
        # Tangential H and E are (w, w') outside; inside (m w, w') for electric waves, whose H is
        # transverse, and (w, m w') for magnetic ones.
        def outside(w, n):
            return (w[0][n], w[1][n])

        def inside(w, n):
            return (m * w[0][n], w[1][n]) if is_electric else (w[0][n], m * w[1][n])

        series = []
        for n in range(1, n_max):
            ox, ix, oy, iy = outside(out_x, n), outside(in_x, n), inside(out_y, n), inside(in_y, n)
            # in_x + r out_x = t in_y  and  out_y + r' in_y = t' out_x
            reflect_out, enter = solve(ox, tuple(-c for c in iy), tuple(-c for c in ix))
            reflect_in, leave = solve(iy, tuple(-c for c in ox), tuple(-c for c in oy))
            series.append((reflect_out, enter, reflect_in, leave))
        yield series


def order_waves(series, order):
    if order == 0:
        return [(1 - reflect_out) / 2 for reflect_out, _, _, _ in series]
    return [-enter * reflect_in ** (order - 1) * leave / 2 for _, enter, reflect_in, leave in series]


def angle_functions(theta_deg, n_max):
    """pi_n = P'_n, tau_n = n (n+1) P_n - mu P'_n; mu P_n - P_{n-1} = (mu^2-1) P'_n/n."""
    mu = mp.cos(mp.mpf(theta_deg) * mp.pi / 180)
    before, legendre = mp.mpf(1), mu
    for n in range(1, n_max):
        derivative = n * (mu * legendre - before) / (mu**2 - 1)
        yield n, derivative, n * (n + 1) * legendre - mu * derivative
        before, legendre = legendre, ((2 * n + 1) * mu * legendre - n * before) / (n + 1)


def rust(value):
    return mp.nstr(value, 20, strip_zeros=False, min_fixed=1, max_fixed=0)


def pair(value):
    return f"({rust(value.real)}, {rust(value.imag)})"


def main():
    n_references = sum(len(orders) for _, _, _, orders in CASES)
    print("//! Written by `reference_orders.py`: see there for the method. Do not edit.\n")
    print("use super::support::DebyeReference;\n")
    print(f"/// One order of the Debye series at {len(ANGLES_DEG)} angles.")
    print(f"pub(crate) const ORDERS: [DebyeReference; {n_references}] = [")
    for x, n, k, orders in CASES:
        mp.mp.dps = digits(x, complex(n, k))
        electric, magnetic = passages(mp.mpf(x), mp.mpc(n, k))
        functions = [list(angle_functions(theta, len(electric) + 1)) for theta in ANGLES_DEG]
        for order in orders:
            a, b = order_waves(electric, order), order_waves(magnetic, order)
            print(f"    DebyeReference {{ x: {x!r}, n: {n!r}, k: {k!r}, order: {order}, amplitudes: &[")
            for theta, at_angle in zip(ANGLES_DEG, functions):
                s1 = s2 = mp.mpc(0)
                for (n_wave, pi_n, tau), an, bn in zip(at_angle, a, b):
                    weight = mp.mpf(2 * n_wave + 1) / (n_wave * (n_wave + 1))
                    s1 += weight * (an * pi_n + bn * tau)
                    s2 += weight * (an * tau + bn * pi_n)
                print(f"        ({theta!r}, {pair(s1)}, {pair(s2)}),", flush=True)
            print("    ] },", flush=True)
    print("];")


if __name__ == "__main__":
    main()
