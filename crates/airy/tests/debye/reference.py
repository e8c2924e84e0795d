"""Reference values for the tests of this crate: bows of the exact Debye series.

pip install mpmath gmpy2
python reference.py > references.rs

The Debye coefficients come from Riccati-Bessel functions that are all recurred upwards, with so many
digits that the instability of that recurrence does not matter; pi_n and tau_n by their textbook
recurrences, and the sum over n term by term. Nothing of it is shared with the crate. Sizes, indices
and angles are the doubles that the tests pass in, taken as exact numbers (angles: as exact degrees).
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


def digits(x):
    """Enough for psi to survive its upward recurrence, and 40 more."""
    n = n_terms(x)
    # Debye's asymptotic form of psi_n beyond the turning point.
    decay = n * mp.acosh(mp.mpf(n) / x) - mp.sqrt(n**2 - x**2)
    return int(2 * decay / mp.log(10) + 60)


def debye(x, m, order):
    """Partial waves of one order of a_n and b_n."""
    n_max = n_terms(x)
    y = m * x
    psi_x, chi_x = riccati(x, n_max)
    psi_y, chi_y = riccati(y, n_max)
    u_x, v_x = zip(*((mp.mpc(p, -c), mp.mpc(p, c)) for p, c in zip(psi_x, chi_x)))
    u_y, v_y = zip(*((mp.mpc(p, -c), mp.mpc(p, c)) for p, c in zip(psi_y, chi_y)))
    du_x, dv_x, du_y, dv_y = (derivatives(w, z) for w, z in ((u_x, x), (v_x, x), (u_y, y), (v_y, y)))
    result = []
    for alpha, beta in ((mp.mpf(1), m), (m, mp.mpf(1))):
        series = []
        for n in range(1, n_max):
            # Continuity of the field at the surface.
            d = alpha * u_x[n] * dv_y[n] - beta * du_x[n] * v_y[n]
            r22 = -(alpha * v_x[n] * dv_y[n] - beta * dv_x[n] * v_y[n]) / d
            r11 = -(alpha * u_x[n] * du_y[n] - beta * du_x[n] * u_y[n]) / d
            t = -4 * m / d**2
            series.append((1 - r22) / 2 if order == 0 else -t * r11 ** (order - 1) / 2)
        result.append(series)
    return result


def intensities(a, b, theta_deg):
    mu = mp.cos(mp.mpf(theta_deg) * mp.pi / 180)
    pi_before, pi_n = mp.mpf(0), mp.mpf(1)
    s1 = s2 = mp.mpc(0)
    for n, (an, bn) in enumerate(zip(a, b), 1):
        tau = n * mu * pi_n - (n + 1) * pi_before
        weight = mp.mpf(2 * n + 1) / (n * (n + 1))
        s1 += weight * (an * pi_n + bn * tau)
        s2 += weight * (an * tau + bn * pi_n)
        pi_before, pi_n = pi_n, ((2 * n + 1) * mu * pi_n - (n + 1) * pi_before) / n
    return [abs(s) ** 2 for s in (s1, s2)]


# 10, 50, 100 and 500 um and 1 mm at 650 nm; the secondary bow; orders 4 to 7.
N = 1.3312
CASES = [(97.0, 2), (483.0, 2), (967.0, 2), (4833.0, 2), (9666.0, 2), (97.0, 3), (967.0, 3), (4833.0, 3),
         (4833.0, 4), (4833.0, 5), (4833.0, 6), (4833.0, 7)]
# First angle and step: 2 degrees to either side of the bow.
ANGLES_DEG = {2: 135.625, 3: 127.625, 4: 40.125, 5: 40.875, 6: 125.25, 7: 147.0}
STEP_DEG = 0.125
# First peaks of the primary: 10 and 30 um.
PEAKS = [(97.0, 139.0, 0.25), (290.0, 138.5, 0.125)]
# The dark side of the primary, 100 um.
DARK_DEG = [132.0, 133.0, 134.0, 135.0]


def rust(value):
    return mp.nstr(value, 12, strip_zeros=True, min_fixed=1, max_fixed=0)


def print_case(x, order, angles_deg, end="},"):
    mp.mp.dps = digits(x)
    a, b = debye(mp.mpf(x), mp.mpf(N), order)
    print(f"    Reference {{ x: {x!r}, order: {order}, intensities: &[")
    for theta in angles_deg:
        s, p = intensities(a, b, theta)
        print(f"        ({theta!r}, [{rust(s)}, {rust(p)}]),", flush=True)
    print(f"    ] {end}")


def main():
    print("//! Written by `reference.py`: see there for the method. Do not edit.\n")
    print("use super::Reference;\n")
    print("/// Refractive index of all references.")
    print(f"pub(crate) const N: f64 = {N!r};\n")
    print("/// Bows, 2 degrees to either side.")
    print(f"pub(crate) const BOWS: [Reference; {len(CASES)}] = [")
    for x, order in CASES:
        first = ANGLES_DEG[order]
        print_case(x, order, [first + STEP_DEG * k for k in range(33)])
    print(f"];\n\n/// First peaks of the primary bow.\npub(crate) const PEAKS: [Reference; {len(PEAKS)}] = [")
    for x, first, step in PEAKS:
        print_case(x, 2, [first + step * k for k in range(21)])
    print("];\n\n/// The dark side of the primary bow.")
    print("pub(crate) const DARK: Reference = ")
    print_case(967.0, 2, DARK_DEG, end="};")


main()
