// OpenVDB's side of the speed comparison that vdb_speed.py runs.
//
//   vdb_speed make FILE none|zip|blosc    writes a ball of noise, 52 million voxels of float
//   vdb_speed read FILE                   reads a file, all of it, and looks at every value
//   vdb_speed write FILE OUT none|zip     reads a file, then writes it
//
// `read` and `write` print one line: seconds, active voxels, the sum of the bits of all active
// values, and the peak memory of the process. Only reading or writing itself is timed.
//
// Build: g++ -O3 -std=c++17 vdb_speed.cc -o vdb_speed -lopenvdb -ltbb -lImath-3_1

#include <openvdb/openvdb.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <iostream>
#include <string>

using namespace openvdb;

namespace {

constexpr int RADIUS = 232;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

double peak_mib()
{
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.rfind("VmHWM:", 0) == 0) return std::stod(line.substr(6)) / 1024.0;
    }
    return 0.0;
}

uint32_t flags_of(const std::string& name)
{
    if (name == "none") return io::COMPRESS_ACTIVE_MASK;
    if (name == "zip") return io::COMPRESS_ACTIVE_MASK | io::COMPRESS_ZIP;
    if (name == "blosc") return io::COMPRESS_ACTIVE_MASK | io::COMPRESS_BLOSC;
    throw std::runtime_error("compression is none, zip or blosc");
}

// Smooth with noise of one percent in the low bits, as simulations and scans have it.
float value(int x, int y, int z)
{
    uint32_t hash = uint32_t(x) * 73856093u ^ uint32_t(y) * 19349663u ^ uint32_t(z) * 83492791u;
    hash = (hash ^ hash >> 15) * 2246822519u;
    const float noise = float(hash >> 8) / float(1 << 24);
    return 1.0f - float(x * x + y * y + z * z) / float(RADIUS * RADIUS) + 0.01f * noise;
}

FloatGrid::Ptr ball()
{
    auto grid = FloatGrid::create(0.0f);
    const int reach = (RADIUS + 7) / 8;
    for (int i = -reach; i < reach; ++i) {
        for (int j = -reach; j < reach; ++j) {
            for (int k = -reach; k < reach; ++k) {
                FloatTree::LeafNodeType leaf(Coord(8 * i, 8 * j, 8 * k), 0.0f);
                for (Index n = 0; n < 512; ++n) {
                    const Coord at = leaf.offsetToGlobalCoord(n);
                    const int64_t r2 = int64_t(at[0]) * at[0] + at[1] * at[1] + at[2] * at[2];
                    if (r2 < RADIUS * RADIUS) leaf.setValueOn(n, value(at[0], at[1], at[2]));
                }
                if (!leaf.isEmpty()) grid->tree().addLeaf(new FloatTree::LeafNodeType(leaf));
            }
        }
    }
    grid->setName("density");
    // Of no class: OpenVDB does not apply zip to fog volumes.
    return grid;
}

GridPtrVecPtr read(const std::string& path)
{
    io::File file(path);
    file.open(/*delayLoad=*/false);
    return file.getGrids();
}

void report(double seconds, const GridPtrVec& grids)
{
    uint64_t n_active = 0, bits = 0;
    for (const GridBase::Ptr& base : grids) {
        const auto grid = gridPtrCast<FloatGrid>(base);
        for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
            for (auto at = leaf->cbeginValueOn(); at; ++at, ++n_active) {
                uint32_t raw;
                std::memcpy(&raw, &*at, sizeof raw);
                bits += raw;
            }
        }
    }
    std::cout << seconds << ' ' << n_active << ' ' << bits << ' ' << peak_mib() << '\n';
}

} // namespace

int main(int argc, char** argv)
{
    initialize();
    const std::string command = argc > 2 ? argv[1] : "";
    if (command == "make" && argc == 4) {
        io::File file(argv[2]);
        file.setCompression(flags_of(argv[3]));
        file.write({ball()});
    } else if (command == "read" && argc == 3) {
        const auto start = Clock::now();
        const auto grids = read(argv[2]);
        report(seconds_since(start), *grids);
    } else if (command == "write" && argc == 5) {
        const auto grids = read(argv[2]);
        const auto start = Clock::now();
        io::File file(argv[3]);
        file.setCompression(flags_of(argv[4]));
        file.write(*grids);
        file.close();
        report(seconds_since(start), *grids);
    } else {
        std::cerr << "usage: vdb_speed make FILE none|zip|blosc | read FILE | write FILE OUT none|zip\n";
        return 2;
    }
}
