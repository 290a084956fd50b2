// Embree's best rays a second on rays and primitives from raw files, by one core's CPU clock.
//
// The library is opened at run time: libembree4 as its first argument. Embree's C interface of
// version 4 is declared here as far as it is used, so no header is needed.
// usage: embree LIB DIR spheres|triangles KIND...      (a KIND `shadow` asks for any hit)
// DIR holds prims.f32 (centre, radius) or verts.f32 and tris.u32, and KIND.f32 (origin, tmin,
// direction, tmax). Prints a line `KIND MRAYS HITS MODE` each, and `build MPRIMS 0 medium` first.
#include <dlfcn.h>
#include <pmmintrin.h>
#include <time.h>
#include <xmmintrin.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace {

constexpr unsigned NONE = ~0u;

// rtcore_ray.h: a packet of N rays, each field N wide; one ray is aligned to 16 bytes.
template <int N>
struct alignas(N == 1 ? 16 : 4 * N) Rays {
  float ox[N], oy[N], oz[N], tnear[N], dx[N], dy[N], dz[N], time[N], tfar[N];
  unsigned mask[N], id[N], flags[N];
};
template <int N>
struct alignas(N == 1 ? 16 : 4 * N) Hits {
  float nx[N], ny[N], nz[N], u[N], v[N];
  unsigned prim[N], geom[N], inst[N], inst_prim[N];
};
template <int N>
struct RayHits {
  Rays<N> ray;
  Hits<N> hit;
};
struct Arguments {
  int flags;
  unsigned features;
  void *context, *filter, *callback;
};

void* library;

template <class F>
F* find(const char* name) {
  void* p = dlsym(library, name);
  if (!p) {
    fprintf(stderr, "the library has no %s\n", name);
    exit(2);
  }
  return reinterpret_cast<F*>(p);
}

std::vector<float> read(const std::string& path) {
  FILE* f = fopen(path.c_str(), "rb");
  if (!f) {
    fprintf(stderr, "cannot open %s\n", path.c_str());
    exit(2);
  }
  fseek(f, 0, SEEK_END);
  std::vector<float> v(ftell(f) / 4);
  rewind(f);
  if (fread(v.data(), 4, v.size(), f) != v.size()) exit(2);
  fclose(f);
  return v;
}

double clock_of(clockid_t which) {
  timespec t;
  clock_gettime(which, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

// Seconds that all rays take; the packets are laid out before the clock runs.
template <int N>
double cast(void* scene, const std::vector<float>& rows, bool any, int flags, size_t* hits) {
  const size_t n = rows.size() / 8, packets = (n + N - 1) / N;
  static std::vector<Rays<N>> packed;
  packed.assign(packets, {});
  for (size_t i = 0; i < packets * N; i++) {
    const float* r = &rows[8 * std::min(i, n - 1)];
    Rays<N>& p = packed[i / N];
    const size_t k = i % N;
    p.ox[k] = r[0], p.oy[k] = r[1], p.oz[k] = r[2], p.tnear[k] = r[3];
    p.dx[k] = r[4], p.dy[k] = r[5], p.dz[k] = r[6];
    p.tfar[k] = i < n ? r[7] : -1.0f;
    p.mask[k] = NONE;
  }
  const std::string suffix = std::to_string(N);
  void* call = dlsym(library, ((any ? "rtcOccluded" : "rtcIntersect") + suffix).c_str());
  Arguments arguments{flags, NONE, nullptr, nullptr, nullptr};
  alignas(64) int valid[N];
  std::fill(valid, valid + N, -1);
  size_t count = 0;
  const double start = clock_of(CLOCK_THREAD_CPUTIME_ID);
  for (const Rays<N>& from : packed) {
    RayHits<N> packet;
    packet.ray = from;
    for (int k = 0; k < N; k++) packet.hit.geom[k] = packet.hit.inst[k] = NONE;
    if constexpr (N == 1) {
      reinterpret_cast<void (*)(void*, void*, Arguments*)>(call)(scene, &packet, &arguments);
    } else {
      reinterpret_cast<void (*)(const int*, void*, void*, Arguments*)>(call)(valid, scene, &packet, &arguments);
    }
    for (int k = 0; k < N; k++) {
      count += any ? packet.ray.tfar[k] < 0 && from.tfar[k] >= 0 : packet.hit.geom[k] != NONE;
    }
  }
  *hits = count;
  return clock_of(CLOCK_THREAD_CPUTIME_ID) - start;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5 || !(library = dlopen(argv[1], RTLD_NOW))) {
    fprintf(stderr, "%s\n", argc < 5 ? "usage: embree LIB DIR spheres|triangles KIND..." : dlerror());
    return 2;
  }
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  const std::string dir = std::string(argv[2]) + "/";
  const bool spheres = !strcmp(argv[3], "spheres");
  enum { TRIANGLES = 0, SPHERES = 50, INDEX = 0, VERTEX = 1, UINT3 = 0x5003, FLOAT3 = 0x9003, FLOAT4 = 0x9004 };
  std::vector<float> vertices = read(dir + (spheres ? "prims.f32" : "verts.f32"));
  std::vector<float> indices = spheres ? std::vector<float>() : read(dir + "tris.u32");
  const size_t width = spheres ? 4 : 3, count = vertices.size() / width;
  const size_t prims = spheres ? count : indices.size() / 3;
  vertices.resize(vertices.size() + 4);  // the last row is read as 16 bytes
  struct Best { double mrays = 0; size_t hits = 0; std::string mode; };
  std::vector<Best> best(argc - 4);
  double build = 0;
  for (const char* isa : {"avx2", "avx512"}) {
    const std::string config = std::string("threads=1,isa=") + isa;
    void* device = find<void*(const char*)>("rtcNewDevice")(config.c_str());
    void* scene = find<void*(void*)>("rtcNewScene")(device);
    find<void(void*, int)>("rtcSetSceneBuildQuality")(scene, 1);
    void* geometry = find<void*(void*, int)>("rtcNewGeometry")(device, spheres ? SPHERES : TRIANGLES);
    auto* share = find<void(void*, int, unsigned, int, const void*, size_t, size_t, size_t)>("rtcSetSharedGeometryBuffer");
    share(geometry, VERTEX, 0, spheres ? FLOAT4 : FLOAT3, vertices.data(), 0, 4 * width, count);
    if (!spheres) share(geometry, INDEX, 0, UINT3, indices.data(), 0, 12, prims);
    find<void(void*)>("rtcCommitGeometry")(geometry);
    find<unsigned(void*, void*)>("rtcAttachGeometry")(scene, geometry);
    const double start = clock_of(CLOCK_PROCESS_CPUTIME_ID);
    find<void(void*)>("rtcCommitScene")(scene);
    build = std::max(build, prims * 1e-6 / (clock_of(CLOCK_PROCESS_CPUTIME_ID) - start));
    if (int error = find<int(void*)>("rtcGetDeviceError")(device)) {
      fprintf(stderr, "error %d of the library\n", error);
      return 2;
    }
    for (int i = 4; i < argc; i++) {
      const bool any = !strcmp(argv[i], "shadow");
      const std::vector<float> rows = read(dir + argv[i] + ".f32");
      auto mode = [&](const char* name, double (*run)(void*, const std::vector<float>&, bool, int, size_t*), int flags) {
        size_t hits = 0;
        std::vector<double> times;
        for (int round = 0; round < 4; round++) times.push_back(run(scene, rows, any, flags, &hits));
        std::sort(times.begin() + 1, times.end());
        const double mrays = rows.size() / 8 * 1e-6 / times[2];
        if (mrays > best[i - 4].mrays) best[i - 4] = {mrays, hits, std::string(isa) + " " + name};
      };
      const int coherent = 1 << 16;
      mode("single", cast<1>, 0);
      mode("packets of 8", cast<8>, 0);
      mode("coherent packets of 8", cast<8>, coherent);
      mode("packets of 16", cast<16>, 0);
      mode("coherent packets of 16", cast<16>, coherent);
    }
    find<void(void*)>("rtcReleaseScene")(scene);
    find<void(void*)>("rtcReleaseDevice")(device);
  }
  printf("build %.3f 0 medium\n", build);
  for (int i = 4; i < argc; i++) {
    printf("%s %.3f %zu %s\n", argv[i], best[i - 4].mrays, best[i - 4].hits, best[i - 4].mode.c_str());
  }
}
