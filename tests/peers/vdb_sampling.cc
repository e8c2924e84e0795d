// The samplers of OpenVDB and NanoVDB for the comparison that vdb_sampling.py runs.
//
//   vdb_sampling make FILE gradient|sparse    writes a drop volume: number density and radius
//   vdb_sampling sample FILE                  times trilinear samples of its number density, and of
//                                             three fields in one grid (nanovdb3)
//
// `sample` prints for each sampler and order of the points: name, order, nanoseconds for a sample
// (best of nine), sum of the samples. The points are told in vdb_sampling.py; samplers that keep the
// last cell or leaf are made anew for each repeat, not for each sample.
//
// Build: g++ -O3 -march=native -std=c++17 [-DWITH_NANOVDB -I.../nanovdb] vdb_sampling.cc
//        -o vdb_sampling -lopenvdb -ltbb -lImath-3_1

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#ifdef WITH_NANOVDB
#include <nanovdb/util/OpenToNanoVDB.h>
#include <nanovdb/util/SampleFromVoxels.h>
#endif

#include <chrono>
#include <cmath>
#include <iostream>
#include <numeric>
#include <string>
#include <vector>

using namespace openvdb;

namespace {

constexpr size_t N_POINTS = 1 << 22;
constexpr int N_REPEATS = 9;
constexpr size_t STRETCH = 1 << 14;
constexpr float STEP = 0.5f;

// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
struct Random
{
    uint64_t state;
    uint64_t next()
    {
        state += 0x9e3779b97f4a7c15;
        uint64_t mixed = (state ^ state >> 30) * 0xbf58476d1ce4e5b9;
        mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111eb;
        return mixed ^ mixed >> 31;
    }
    float unit() { return float(next() >> 40) / float(1 << 24); }
};

// A point in a random leaf.
Vec3f point(Random& random, const std::vector<Coord>& leaves)
{
    const Coord& leaf = leaves[random.next() % leaves.size()];
    const float x = random.unit(), y = random.unit(), z = random.unit();
    return Vec3f(leaf[0] + 7 * x, leaf[1] + 7 * y, leaf[2] + 7 * z);
}

std::vector<Vec3f> scattered(const std::vector<Coord>& leaves)
{
    Random random{1};
    std::vector<Vec3f> points;
    while (points.size() < N_POINTS) points.push_back(point(random, leaves));
    return points;
}

// Along lines from one such point to another, in steps of half a voxel.
std::vector<Vec3f> coherent(const std::vector<Coord>& leaves)
{
    Random random{2};
    std::vector<Vec3f> points;
    while (points.size() < N_POINTS) {
        const Vec3f from = point(random, leaves), to = point(random, leaves);
        const float dx = to[0] - from[0], dy = to[1] - from[1], dz = to[2] - from[2];
        const float length = std::sqrt(dx * dx + dy * dy + dz * dz);
        const float step = STEP / length;
        for (int n = 0; n * STEP < length && points.size() < N_POINTS; ++n) {
            const float t = n * step;
            points.emplace_back(from[0] + t * dx, from[1] + t * dy, from[2] + t * dz);
        }
    }
    return points;
}

// Short stretches of points, each at its best: other programs on the machine then hardly count.
template <typename MakeSampler>
void time(const char* name, const char* order, const std::vector<Vec3f>& points, MakeSampler make)
{
    std::vector<double> best(points.size() / STRETCH, 1e300);
    double sum = 0.0;
    for (int repeat = 0; repeat < N_REPEATS; ++repeat) {
        auto sample = make();
        sum = 0.0;
        for (size_t stretch = 0; stretch < best.size(); ++stretch) {
            const Vec3f* at = points.data() + stretch * STRETCH;
            const auto start = std::chrono::steady_clock::now();
            for (size_t n = 0; n < STRETCH; ++n) sum += sample(at[n]);
            const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
            best[stretch] = std::min(best[stretch], taken.count());
        }
    }
    const double total = std::accumulate(best.begin(), best.end(), 0.0);
    std::cout << name << ' ' << order << ' ' << 1e9 * total / points.size() << ' ' << sum << '\n';
}

#ifdef WITH_NANOVDB
// Three fields in one grid, as drops have three moments.
Vec3SGrid::Ptr moments(const FloatGrid& number)
{
    auto grid = Vec3SGrid::create(Vec3s(0.0f));
    auto accessor = grid->getAccessor();
    for (auto at = number.cbeginValueOn(); at; ++at) {
        accessor.setValue(at.getCoord(), Vec3s(*at, 2.0f * *at, 3.0f * *at));
    }
    return grid;
}

// The value, of which the compiler must compute every component.
nanovdb::Vec3f kept(nanovdb::Vec3f value)
{
    asm volatile("" : : "g"(&value) : "memory");
    return value;
}
#endif

void sample(const std::string& path)
{
    io::File file(path);
    file.open(false);
    const auto grid = gridPtrCast<FloatGrid>(file.readGrid("number_density"));
    std::vector<Coord> leaves;
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) leaves.push_back(leaf->origin());
#ifdef WITH_NANOVDB
    auto handle = nanovdb::openToNanoVDB(*grid);
    const auto* nano = handle.grid<float>();
    auto handle3 = nanovdb::openToNanoVDB(*moments(*grid));
    const auto* nano3 = handle3.grid<nanovdb::Vec3f>();
#endif
    std::cout.precision(10);
    for (const char* order : {"coherent", "random"}) {
        const auto points = order[0] == 'c' ? coherent(leaves) : scattered(leaves);
        time("openvdb", order, points, [&] {
            return [accessor = grid->getConstAccessor()](const Vec3f& at) {
                return tools::BoxSampler::sample(accessor, Vec3d(at));
            };
        });
#ifdef WITH_NANOVDB
        // The accessor outlives the sampler, which keeps a reference to it.
        const auto accessor = nano->getAccessor();
        time("nanovdb", order, points, [&] {
            return [sampler = nanovdb::createSampler<1>(accessor)](const Vec3f& at) {
                return sampler(nanovdb::Vec3f(at[0], at[1], at[2]));
            };
        });
        const auto accessor3 = nano3->getAccessor();
        time("nanovdb3", order, points, [&] {
            return [sampler = nanovdb::createSampler<1>(accessor3)](const Vec3f& at) {
                return kept(sampler(nanovdb::Vec3f(at[0], at[1], at[2])))[0];
            };
        });
#endif
    }
}

// Density that grows with height, everywhere in 64 cubed voxels.
FloatGrid::Ptr gradient()
{
    auto grid = FloatGrid::create(0.0f);
    auto accessor = grid->getAccessor();
    for (int x = 0; x < 64; ++x) {
        for (int y = 0; y < 64; ++y) {
            for (int z = 0; z < 64; ++z) accessor.setValue(Coord(x, y, z), 100.0f + 10.0f * y + x);
        }
    }
    return grid;
}

// Eleven clouds in 512 cubed voxels, a twentieth of them.
FloatGrid::Ptr sparse()
{
    auto grid = FloatGrid::create(0.0f);
    auto accessor = grid->getAccessor();
    Random random{3};
    for (int cloud = 0; cloud < 11; ++cloud) {
        const float x = random.unit(), y = random.unit(), z = random.unit();
        const int radius = 45 + int(14 * random.unit());
        const auto place = [&](float at) { return radius + int((511 - 2 * radius) * at); };
        const Coord center(place(x), place(y), place(z));
        for (int i = -radius; i <= radius; ++i) {
            for (int j = -radius; j <= radius; ++j) {
                for (int k = -radius; k <= radius; ++k) {
                    const float r2 = float(i * i + j * j + k * k) / float(radius * radius);
                    if (r2 >= 1.0f) continue;
                    const Coord at(center[0] + i, center[1] + j, center[2] + k);
                    accessor.setValue(at, accessor.getValue(at) + 1000.0f * std::exp(-3.0f * r2));
                }
            }
        }
    }
    return grid;
}

void make(const std::string& path, const std::string& kind)
{
    auto number = kind == "gradient" ? gradient() : sparse();
    number->setName("number_density");
    // One radius everywhere: the background of a grid without voxels.
    auto radius = FloatGrid::create(1e-4f);
    radius->setName("effective_radius");
    io::File file(path);
    file.setCompression(io::COMPRESS_ACTIVE_MASK);
    file.write({number, radius});
}

} // namespace

int main(int argc, char** argv)
{
    initialize();
    const std::string command = argc > 2 ? argv[1] : "";
    if (command == "make" && argc == 4) {
        make(argv[2], argv[3]);
    } else if (command == "sample" && argc == 3) {
        sample(argv[2]);
    } else {
        std::cerr << "usage: vdb_sampling make FILE gradient|sparse | sample FILE\n";
        return 2;
    }
}
