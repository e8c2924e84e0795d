// Writes VDB files of every kind with OpenVDB itself, and what OpenVDB reads back from them.
//
//   vdb_matrix OUTDIR
//
// For each NAME.vdb there is a NAME.txt, one entry a line, numbers as the hexadecimal digits of
// their bits (vectors: components joined by commas):
//
//   file_item NAME TYPE TEXT             metadata of the file
//   grid TYPE CLASS BACKGROUND           starts a grid; its name is in the item `name`
//   item NAME TYPE TEXT                  metadata of the grid
//   map M00 M01 .. M33                   index to world, 4x4 by rows, for row vectors
//   active N                             number of active voxels, decimal
//   leaf X Y Z MASK0..MASK7 V0 .. V511   each leaf
//   tile X Y Z DIM ACTIVE VALUE          each tile that is active or not the background
//   probe X Y Z ACTIVE VALUE             random voxels
//
// Build: g++ -O1 -std=c++17 vdb_matrix.cc -o vdb_matrix -lopenvdb -ltbb -lImath-3_1

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <cstring>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <random>
#include <sstream>

using namespace openvdb;

namespace {

std::string directory;
int n_files = 0;

// ---- Numbers as text ----

template <typename Bits, typename T>
std::string bits(const T& value)
{
    Bits raw;
    static_assert(sizeof raw == sizeof value, "bits of another size");
    std::memcpy(&raw, &value, sizeof raw);
    std::ostringstream out;
    out << std::hex << std::setw(2 * sizeof raw) << std::setfill('0') << uint64_t(raw);
    return out.str();
}

std::string text(float value) { return bits<uint32_t>(value); }
std::string text(double value) { return bits<uint64_t>(value); }
std::string text(int32_t value) { return bits<uint32_t>(value); }
std::string text(bool value) { return value ? "01" : "00"; }
std::string text(const Vec3s& v) { return text(v[0]) + "," + text(v[1]) + "," + text(v[2]); }

// ---- What OpenVDB reads ----

void describe_items(std::ostream& out, const std::string& keyword, const MetaMap& items)
{
    for (auto item = items.beginMeta(); item != items.endMeta(); ++item) {
        out << keyword << ' ' << item->first << ' ' << item->second->typeName() << ' '
            << item->second->str() << '\n';
    }
}

template <typename GridT>
void describe_tree(std::ostream& out, const GridT& grid)
{
    const auto& tree = grid.tree();
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
        const Coord origin = leaf->origin();
        out << "leaf " << origin[0] << ' ' << origin[1] << ' ' << origin[2];
        for (int word = 0; word < 8; ++word) {
            out << ' ' << bits<uint64_t>(leaf->valueMask().template getWord<uint64_t>(word));
        }
        for (Index i = 0; i < 512; ++i) out << ' ' << text(leaf->getValue(i));
        out << '\n';
    }
    auto value = tree.cbeginValueAll();
    value.setMaxDepth(value.getLeafDepth() - 1);
    for (; value; ++value) {
        if (!value.isValueOn() && text(*value) == text(tree.background())) continue;
        const CoordBBox box = value.getBoundingBox();
        out << "tile " << box.min()[0] << ' ' << box.min()[1] << ' ' << box.min()[2] << ' '
            << box.dim()[0] << ' ' << value.isValueOn() << ' ' << text(*value) << '\n';
    }
    std::mt19937 random(5);
    std::uniform_int_distribution<int> near(-300, 300), far(-20000, 20000);
    for (int n = 0; n < 600; ++n) {
        auto& range = n % 3 == 0 ? far : near;
        const int x = range(random), y = range(random), z = range(random);
        const Coord voxel(x, y, z);
        out << "probe " << x << ' ' << y << ' ' << z << ' ' << tree.isValueOn(voxel) << ' '
            << text(tree.getValue(voxel)) << '\n';
    }
}

template <typename GridT>
bool describe_as(std::ostream& out, const GridBase& base)
{
    if (!base.isType<GridT>()) return false;
    const auto& grid = static_cast<const GridT&>(base);
    out << "grid " << grid.valueType() << ' '
        << (grid.getGridClass() == GRID_FOG_VOLUME ? "fog_volume"
            : grid.getGridClass() == GRID_LEVEL_SET ? "level_set" : "unknown")
        << ' ' << text(grid.background()) << '\n';
    describe_items(out, "item", grid);
    out << "map";
    const math::Mat4d matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) out << ' ' << text(matrix(row, column));
    }
    out << "\nactive " << grid.activeVoxelCount() << '\n';
    describe_tree(out, grid);
    return true;
}

void describe(const std::string& name)
{
    std::ofstream out(directory + "/" + name + ".txt");
    std::ifstream stream(directory + "/" + name + ".vdb", std::ios::binary);
    io::Stream archive(stream, /*delayLoad=*/false);
    describe_items(out, "file_item", *archive.getMetadata());
    for (const GridBase::Ptr& grid : *archive.getGrids()) {
        if (!describe_as<FloatGrid>(out, *grid) && !describe_as<DoubleGrid>(out, *grid)
            && !describe_as<Vec3SGrid>(out, *grid) && !describe_as<Int32Grid>(out, *grid)
            && !describe_as<BoolGrid>(out, *grid)) {
            throw std::runtime_error("a grid of an unexpected type");
        }
    }
    ++n_files;
}

void write(const std::string& name, const GridPtrVec& grids, uint32_t compression,
    const MetaMap& items = MetaMap())
{
    io::File file(directory + "/" + name + ".vdb");
    file.setCompression(compression);
    file.write(grids, items);
    file.close();
    describe(name);
}

void write_stream(const std::string& name, const GridPtrVec& grids, uint32_t compression)
{
    std::ofstream out(directory + "/" + name + ".vdb", std::ios::binary);
    io::Stream archive(out);
    archive.setCompression(compression);
    archive.write(grids);
    out.close();
    describe(name);
}

// ---- Content ----

template <typename T> T make(double value) { return T(value); }
template <> bool make<bool>(double value) { return (int64_t(value * 4) & 1) != 0; }
template <> Vec3s make<Vec3s>(double value)
{
    return Vec3s(float(value), float(0.5 * value), float(1 - value));
}

// Leaves whose inactive voxels take every form that mask compression knows, dense and sparse
// leaves on both sides of zero, and tiles of every size, active and not.
template <typename GridT>
typename GridT::Ptr content(double background)
{
    using T = typename GridT::ValueType;
    auto grid = GridT::create(make<T>(background));
    auto& tree = grid->tree();
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(-100, 100);
    const T bg = grid->background();
    const T minus = math::negative(bg);
    for (int n = 0; n < 18; ++n) {
        const Coord origin(8 * (n * 7 - 60), 8 * (n % 5 - 2), 8 * ((n * n) % 40 - 20));
        auto* leaf = tree.touchLeaf(origin);
        const int kind = n % 9;
        for (Index i = 0; i < 512; ++i) {
            const bool odd = (i * 2654435761u >> 13 & 1) != 0;
            T inactive = bg;
            if (kind == 1) inactive = minus;
            if (kind == 2) inactive = make<T>(7.5);
            if (kind == 3) inactive = odd ? minus : bg;
            if (kind == 4) inactive = odd ? make<T>(7.5) : bg;
            if (kind == 5) inactive = odd ? make<T>(7.5) : make<T>(9.25);
            if (kind == 6) inactive = make<T>(double(i % 17));
            const bool active = kind == 7 || (kind != 8 && (i * 40503u >> 7) % 3 == 0);
            if (active) leaf->setValueOn(i, make<T>(uniform(random)));
            else leaf->setValueOff(i, inactive);
        }
    }
    tree.addTile(1, Coord(8, 1024, 16), make<T>(2.5), true);
    tree.addTile(1, Coord(16, 1024, 16), make<T>(3.5), false);
    tree.addTile(2, Coord(-128, 2048, 0), make<T>(4.5), true);
    tree.addTile(2, Coord(-256, 2048, 0), minus, false);
    tree.addTile(3, Coord(8192, -8192, 4096), make<T>(5.5), true);
    tree.addTile(3, Coord(-8192, -8192, 4096), make<T>(6.5), false);
    grid->setName("content");
    grid->setTransform(math::Transform::createLinearTransform(0.25));
    return grid;
}

struct Storage { const char* name; uint32_t flags; };

const Storage storages[] = {
    {"none", io::COMPRESS_NONE},
    {"mask", io::COMPRESS_ACTIVE_MASK},
    {"zip", io::COMPRESS_ZIP},
    {"zip_mask", io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK},
    {"blosc", io::COMPRESS_BLOSC},
    {"blosc_mask", io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK},
};

template <typename GridT>
void write_types(const std::string& type, bool has_half)
{
    for (const Storage& storage : storages) {
        for (double background : {0.0, 3.0}) {
            for (bool half : {false, true}) {
                if (half && !has_half) continue;
                auto grid = content<GridT>(background);
                grid->setSaveFloatAsHalf(half);
                const std::string name = type + (half ? "_half_" : "_") + storage.name
                    + (background == 0.0 ? "_bg0" : "_bg3");
                write(name, {grid}, storage.flags);
            }
        }
    }
}

// A few voxels, so that little stands beside what is tested.
FloatGrid::Ptr small(const std::string& name)
{
    auto grid = FloatGrid::create(0.0f);
    for (int i = 0; i < 40; ++i) grid->tree().setValue(Coord(i, 3 * i % 17, i * i % 31), 0.5f + i);
    grid->setName(name);
    grid->setGridClass(GRID_FOG_VOLUME);
    return grid;
}

void write_maps()
{
    const math::Mat4d sheared(
        2.0, 0.5, 0.0, 0.0, 0.1, 3.0, 0.2, 0.0, -0.3, 0.0, 1.5, 0.0, 10.0, 20.0, 30.0, 1.0);
    const std::pair<const char*, math::MapBase::Ptr> maps[] = {
        {"uniform_scale", math::MapBase::Ptr(new math::UniformScaleMap(0.1))},
        {"scale", math::MapBase::Ptr(new math::ScaleMap(Vec3d(0.1, 0.2, -0.3)))},
        {"translation", math::MapBase::Ptr(new math::TranslationMap(Vec3d(0.1, -20.7, 1e6)))},
        {"uniform_scale_translate",
            math::MapBase::Ptr(new math::UniformScaleTranslateMap(0.1, Vec3d(1, 2, 3)))},
        {"scale_translate",
            math::MapBase::Ptr(new math::ScaleTranslateMap(Vec3d(0.1, 2, 3), Vec3d(1, 2, 3)))},
        {"affine", math::MapBase::Ptr(new math::AffineMap(sheared))},
        {"unitary", math::MapBase::Ptr(new math::UnitaryMap(Vec3d(1, 2, 3), 0.7))},
    };
    for (const auto& map : maps) {
        auto grid = small("density");
        grid->setTransform(math::Transform::Ptr(new math::Transform(map.second)));
        write(std::string("map_") + map.first, {grid}, io::COMPRESS_ACTIVE_MASK);
    }
}

void write_files()
{
    auto density = small("density");
    auto radius = small("radius");
    radius->setSaveFloatAsHalf(true);
    GridBase::Ptr instance = density->copyGrid();
    instance->setName("instance");
    instance->setTransform(math::Transform::createLinearTransform(3.0));
    const GridPtrVec several{density, radius, instance, content<BoolGrid>(0)};
    for (const Storage& storage : storages) {
        write(std::string("several_") + storage.name, several, storage.flags);
        write_stream(std::string("stream_") + storage.name, several, storage.flags);
    }

    write("same_names", {small("twin"), small("twin"), small("")}, io::COMPRESS_ACTIVE_MASK);
    write("empty", {FloatGrid::create(4.0f)}, io::COMPRESS_ACTIVE_MASK);
    write("no_grids", {}, io::COMPRESS_ACTIVE_MASK);

    auto sphere = tools::createLevelSetSphere<FloatGrid>(20.0f, Vec3f(1, 2, 3), 0.5f);
    sphere->setName("surface");
    write("level_set", {sphere}, io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK);

    // Kept as crates/vdb/tests/data/blosc.vdb, for the tests that need no OpenVDB.
    auto ball = FloatGrid::create(0.0f);
    for (int x = -10; x <= 10; ++x) {
        for (int y = -10; y <= 10; ++y) {
            for (int z = -10; z <= 10; ++z) {
                if (x * x + y * y + z * z >= 100) continue;
                const float value = 0.25f * float((7 * x + 3 * y + z) & 63);
                ball->tree().setValue(Coord(x + 16, y + 16, z + 16), value);
            }
        }
    }
    ball->setName("ball");
    write("ball", {ball}, io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK);

    auto far = FloatGrid::create(1.0f);
    far->tree().setValue(Coord::max(), 2.0f);
    far->tree().setValue(Coord::min(), 3.0f);
    far->setName("far");
    write("far", {far}, io::COMPRESS_ACTIVE_MASK);

    MetaMap items;
    items.insertMeta("comment", StringMetadata("two words, \xc3\xa9"));
    items.insertMeta("number", DoubleMetadata(0.1));
    auto grid = small("density");
    grid->insertMeta("a_bool", BoolMetadata(true));
    grid->insertMeta("a_double", DoubleMetadata(-2.5));
    grid->insertMeta("a_float", FloatMetadata(0.5f));
    grid->insertMeta("a_string", StringMetadata("units m^-3"));
    grid->insertMeta("a_vec2d", Vec2DMetadata(Vec2d(1, 2)));
    grid->insertMeta("a_vec3d", Vec3DMetadata(Vec3d(1, 2.5, -3)));
    grid->insertMeta("a_vec3i", Vec3IMetadata(Vec3i(1, 2, -3)));
    grid->insertMeta("a_vec3s", Vec3SMetadata(Vec3s(1, 2.5, -3)));
    grid->insertMeta("an_int32", Int32Metadata(-7));
    grid->insertMeta("an_int64", Int64Metadata(int64_t(1) << 40));
    write("items", {grid}, io::COMPRESS_ACTIVE_MASK, items);
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 2) {
        std::cerr << "usage: vdb_matrix OUTDIR\n";
        return 2;
    }
    directory = argv[1];
    initialize();
    write_types<FloatGrid>("float", true);
    write_types<DoubleGrid>("double", true);
    write_types<Vec3SGrid>("vec3s", true);
    write_types<Int32Grid>("int32", false);
    write_types<BoolGrid>("bool", false);
    write_maps();
    write_files();
    std::cout << n_files << " files written by OpenVDB " << getLibraryVersionString() << '\n';
}
