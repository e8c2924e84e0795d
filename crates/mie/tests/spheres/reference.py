"""Reference values for the tests of this crate, in arbitrary precision.

pip install mpmath gmpy2
python reference.py > references.rs

Lorenz-Mie and Debye coefficients from Riccati-Bessel functions that are all recurred upwards, with
so many digits that the instability of that recurrence does not matter; pi_n and tau_n by their
textbook recurrences. It shares no algorithm with the crate. Sizes, refractive indices and angles
are the doubles the tests pass in, taken as exact numbers (angles: as exact degrees).
"""
import mpmath as mp


def riccati(z, n_max):
    """psi_n, chi_n for n = 0..n_max, with h = psi - i chi."""
    psi = [mp.sin(z), mp.sin(z) / z - mp.cos(z)]
    chi = [mp.cos(z), mp.cos(z) / z + mp.sin(z)]
    for n in range(1, n_max):
        psi.append((2 * n + 1) / z * psi[n] - psi[n - 1])
        chi.append((2 * n + 1) / z * chi[n] - chi[n - 1])
    return psi, chi


def derivatives(w, z):
    return [None] + [w[n - 1] - n * w[n] / z for n in range(1, len(w))]


def n_terms(x):
    return int(x + 8 * x ** (1 / 3) + 24)


def digits(x, m):
    """Enough for psi to survive its upward recurrence, and 40 more."""
    z = min(x, abs(m) * x)
    n = n_terms(x)
    # Debye's asymptotic form of psi_n beyond the turning point.
    decay = n * mp.acosh(n / z) - mp.sqrt(n**2 - z**2) if n > z else 0
    return int(2 * decay / mp.log(10) + abs(m.imag) * x + 60)


def mie(x, m):
    n_max = n_terms(x)
    y = m * x
    psi_x, chi_x = riccati(x, n_max)
    psi_y, _ = riccati(y, n_max)
    dpsi_x, dchi_x, dpsi_y = derivatives(psi_x, x), derivatives(chi_x, x), derivatives(psi_y, y)
    a, b = [], []
    for n in range(1, n_max):
        xi, dxi = psi_x[n] - 1j * chi_x[n], dpsi_x[n] - 1j * dchi_x[n]
        a.append((m * psi_y[n] * dpsi_x[n] - psi_x[n] * dpsi_y[n])
                 / (m * psi_y[n] * dxi - xi * dpsi_y[n]))
        b.append((psi_y[n] * dpsi_x[n] - m * psi_x[n] * dpsi_y[n])
                 / (psi_y[n] * dxi - m * xi * dpsi_y[n]))
    return a, b


def debye(x, m, order):
    n_max = n_terms(x)
    y = m * x
    psi_x, chi_x = riccati(x, n_max)
    psi_y, chi_y = riccati(y, n_max)
    u_x, v_x = zip(*((p - 1j * c, p + 1j * c) for p, c in zip(psi_x, chi_x)))
    u_y, v_y = zip(*((p - 1j * c, p + 1j * c) for p, c in zip(psi_y, chi_y)))
    du_x, dv_x, du_y, dv_y = (derivatives(w, z) for w, z in ((u_x, x), (v_x, x), (u_y, y), (v_y, y)))
    result = []
    for alpha, beta in ((mp.mpf(1), m), (m, mp.mpf(1))):
        series = []
        for n in range(1, n_max):
            # Continuity of the field at the surface, for an outgoing wave from inside and an
            # incoming wave from outside: amplitudes of what is reflected and what is transmitted.
            d = alpha * u_x[n] * dv_y[n] - beta * du_x[n] * v_y[n]
            r22 = -(alpha * v_x[n] * dv_y[n] - beta * dv_x[n] * v_y[n]) / d
            r11 = -(alpha * u_x[n] * du_y[n] - beta * du_x[n] * u_y[n]) / d
            t = -4 * m / d**2
            series.append((1 - r22) / 2 if order == 0 else -t * r11 ** (order - 1) / 2)
        result.append(series)
    return result


def amplitudes(a, b, theta_deg):
    mu = mp.cos(mp.mpf(theta_deg) * mp.pi / 180)
    pi_before, pi_n = mp.mpf(0), mp.mpf(1)
    s1 = s2 = mp.mpc(0)
    for n, (an, bn) in enumerate(zip(a, b), 1):
        tau = n * mu * pi_n - (n + 1) * pi_before
        weight = mp.mpf(2 * n + 1) / (n * (n + 1))
        s1 += weight * (an * pi_n + bn * tau)
        s2 += weight * (an * tau + bn * pi_n)
        pi_before, pi_n = pi_n, ((2 * n + 1) * mu * pi_n - (n + 1) * pi_before) / n
    return s1, s2


def efficiencies(x, a, b):
    q_ext = 2 / x**2 * sum((2 * n + 1) * (p + q).real for n, (p, q) in enumerate(zip(a, b), 1))
    q_sca = 2 / x**2 * sum((2 * n + 1) * (abs(p)**2 + abs(q)**2) for n, (p, q) in enumerate(zip(a, b), 1))
    g = mp.mpf(0)
    for n in range(1, len(a)):
        p, q, p1, q1 = a[n - 1], b[n - 1], a[n], b[n]
        g += mp.mpf(n * (n + 2)) / (n + 1) * (p * mp.conj(p1) + q * mp.conj(q1)).real
        g += mp.mpf(2 * n + 1) / (n * (n + 1)) * (p * mp.conj(q)).real
    return q_ext, q_sca, 4 * g / (x**2 * q_sca)


MIE = [
    (1e-6, 1.333, 0.0), (1e-3, 1.333, 1e-3), (0.1, 1.333, 0.0), (1.0, 1.333, 0.0), (3.7, 1.5, 0.1), (10.0, 0.75, 0.0),
    (10.0, 1.333, 1e-5), (62.8, 1.3337, 0.0), (100.0, 10.0, 10.0), (237.5, 1.31, 0.0),
    (1000.0, 1.333, 0.0), (1000.0, 0.75, 0.0), (5000.0, 1.333, 1e-6), (10000.0, 1.333, 0.0),
    (20000.0, 1.3335, 0.0), (20000.0, 1.333, 1e-5), (50000.0, 1.333, 0.0),
    # A metal, a mirror, a large black sphere, a high index.
    (50.0, 0.05, 3.0), (100.0, 1.333, 30.0), (1000.0, 1.5, 1.0), (300.0, 4.0, 0.0),
]
ANGLES_DEG = [0.0, 0.05, 2.5, 42.0, 90.0, 138.0, 177.5, 179.5, 180.0]
DEBYE = [
    (10.0, 1.333, 0.0, 2), (100.0, 1.333, 0.0, 0), (100.0, 1.333, 0.0, 2), (100.0, 1.33, 0.01, 2), (100.0, 1.33, 0.1, 1),
    (1000.0, 1.333, 0.0, 1), (1000.0, 1.333, 0.0, 2), (1000.0, 1.333, 0.0, 3), (1000.0, 1.333, 0.0, 7), (1000.0, 1.333, 1e-3, 3),
    (10000.0, 1.333, 0.0, 2),
]
DEBYE_ANGLES_DEG = [0.0, 30.0, 90.0, 125.0, 129.0, 138.0, 150.0, 180.0]


def rust(value):
    return mp.nstr(value, 20, strip_zeros=False, min_fixed=1, max_fixed=0)


def pair(value):
    return f"({rust(value.real)}, {rust(value.imag)})"


def main():
    print("//! Written by `reference.py`: see there for the method. Do not edit.\n")
    print("use super::support::DebyeReference;\nuse super::support::MieReference;\n")
    print("/// Lorenz-Mie spheres at 9 angles.")
    print(f"pub(crate) const MIE: [MieReference; {len(MIE)}] = [")
    for x, n, k in MIE:
        mp.mp.dps = digits(x, complex(n, k))
        a, b = mie(mp.mpf(x), mp.mpc(n, k))
        q_ext, q_sca, g = efficiencies(mp.mpf(x), a, b)
        print(f"    MieReference {{ x: {x!r}, n: {n!r}, k: {k!r},")
        print(f"        q_ext: {rust(q_ext)}, q_sca: {rust(q_sca)}, g: {rust(g)}, amplitudes: &[")
        for theta in ANGLES_DEG:
            s1, s2 = amplitudes(a, b, theta)
            print(f"            ({theta!r}, {pair(s1)}, {pair(s2)}),", flush=True)
        print("        ] },")
    print("];\n\n/// One order of the Debye series at 8 angles.")
    print(f"pub(crate) const DEBYE: [DebyeReference; {len(DEBYE)}] = [")
    for x, n, k, order in DEBYE:
        mp.mp.dps = digits(x, complex(n, k))
        a, b = debye(mp.mpf(x), mp.mpc(n, k), order)
        print(f"    DebyeReference {{ x: {x!r}, n: {n!r}, k: {k!r}, order: {order}, amplitudes: &[")
        for theta in DEBYE_ANGLES_DEG:
            s1, s2 = amplitudes(a, b, theta)
            print(f"        ({theta!r}, {pair(s1)}, {pair(s2)}),", flush=True)
        print("    ] },")
    print("];")


if __name__ == "__main__":
    main()
