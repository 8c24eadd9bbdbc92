/* Leafwise plugins, ABI 1: the C layout of systems, realizations, dynamic approximations and step
 * maps from shared libraries. C11 or C++17.
 *
 * Generated from the crate leafwise-plugin-abi; to regenerate, in the workspace:
 *     cargo run -p leafwise-plugin-abi --example header
 * Build C plugins with -ffp-contract=off and without -ffast-math.
 *
 * Rules that hold everywhere
 *
 * Growth. A minor version only appends fields. A struct that starts with `struct_size` says how many of
 *   its bytes its writer knows; the reader takes the smaller of that and its own size, and fields
 *   behind it as NULL or 0: LW_HAS asks for one. Structs without `struct_size`, and LwLifecycle, are
 *   frozen for ABI 1. LwEntry.abi_minor is the lowest minor version the plugin needs of its host.
 * NULL. Every function field may be NULL; "required" means that the host refuses the part otherwise.
 *   Reserved fields are 0. Unknown flag bits are ignored, an unknown status is LW_ERROR.
 * Strings are UTF-8 with a NUL at the end. Those reachable from LwEntry live until the process ends.
 * Memory. Nothing is allocated on one side and freed on the other. The caller owns every buffer of a
 *   call, and the callee keeps no pointer into it; inputs and output do not overlap. Inputs are not
 *   written to.
 * Purity. A map's result depends on the instance and on the point alone: not on earlier calls, nor on
 *   which other points share the batch. The same point gives the same bits.
 * Threads. No two calls on one instance overlap in time, unless the part is LW_FLAG_SHAREABLE;
 *   consecutive calls may come from different threads; different instances are made, called and
 *   destroyed in parallel. What a call needs lies in its instance or on the stack, not in static memory
 *   (`static`, Fortran's SAVE and COMMON). A plugin starts no threads of its own by default.
 * Process. A plugin leaves floating-point control registers, locale, signal handlers and panic hook as
 *   they were, does not call `exit` (Fortran: STOP), and lets no exception or panic out. It is never
 *   unloaded. What it prints goes to standard error.
 * Units. Numbers are doubles in the units of the scene. Pi_ij = {x_i, x_j} and
 *   dx/dt = {H, x} = -Pi grad H, whatever convention a part's expressions use. */
#ifndef LEAFWISE_PLUGIN_H
#define LEAFWISE_PLUGIN_H


#include <stddef.h>
#include <stdint.h>

/* The letters of LwEntry.magic, as an initializer. */
#define LW_MAGIC {'L', 'E', 'A', 'F', 'W', 'I', 'S', 'E'}
/* The name of the entry function. */
#define LW_ENTRY_SYMBOL "leafwise_plugin_entry_v1"

/* Makes the entry function visible: the only symbol a plugin needs to export. */
#if defined(_WIN32)
#define LW_EXPORT __declspec(dllexport)
#else
#define LW_EXPORT __attribute__((visibility("default")))
#endif

/* Whether the writer of *args, a struct with `struct_size`, knows a field: newer ones are asked for
 * before they are read. */
#define LW_HAS(args, field)                                                                        \
    ((size_t)((const char *)&(args)->field - (const char *)(args)) + sizeof((args)->field) <=      \
     (args)->struct_size)

#if defined(__cplusplus)
#define LW_STATIC_ASSERT(condition, text) static_assert(condition, text)
#else
#define LW_STATIC_ASSERT(condition, text) _Static_assert(condition, text)
#endif

/* Defined below: functions that make instances and what they are given refer to each other. */
typedef struct LwCreate LwCreate;


// Done; the whole output is written.
#define LW_OK 0

// The point is outside the part's domain (the neighbourhood U_ε of a local realization), or an
// inner iteration did not converge there. The instance is unchanged; the host may try a smaller
// epsilon or h.
#define LW_DISCARD 1

// The call failed for another reason, told in `LwError`. The instance is unchanged and may be
// called again.
#define LW_ERROR -1

// The instance is broken (a caught panic, a violated invariant): the host never calls it again,
// not even to destroy it.
#define LW_FATAL -2

// The part does not serve this dimension, tensor, parameter or partner (from `create` or
// `properties`), or this instance does not offer the function that was called. A property of the
// instance: asking again gives the same answer.
#define LW_UNSUPPORTED -3

// `LwSetting.kind`: a whole number.
#define LW_SETTING_INTEGER 1

// `LwSetting.kind`: a number.
#define LW_SETTING_REAL 2

// `LwSetting.kind`: a word.
#define LW_SETTING_TEXT 3

// `LwPart.kind`: a Poisson system; `functions` is an `LwSystem`.
#define LW_KIND_SYSTEM 1

// `LwPart.kind`: realization data; `functions` is an `LwRealization`.
#define LW_KIND_REALIZATION 2

// `LwPart.kind`: a dynamic approximation; `functions` is an `LwDynamics`.
#define LW_KIND_DYNAMICS 3

// `LwPart.kind`: a step map; `functions` is an `LwStepMap`.
#define LW_KIND_STEP_MAP 4

// Realization: α̂ is Poisson and β̂ anti-Poisson to round-off; `order` is ignored.
#define LW_FLAG_EXACT 1

// Dynamic approximation: L is Lagrangian to round-off (θ̂ closed, Σ symplectic). Without it no
// method made of it is declared a Poisson map.
#define LW_FLAG_SYMPLECTIC 2

// Dynamic approximation, step map: Φ_{−h} ∘ Φ_h = id; for a dynamic approximation over a reversible
// realization.
#define LW_FLAG_SELF_ADJOINT 4

// Dynamic approximation, step map: known not to be self-adjoint. With neither flag it is unknown.
#define LW_FLAG_NOT_SELF_ADJOINT 8

// Realization: points of S are pairs z = (x, p), d_S = 2 d, ω canonical, σ(x) = (x, 0).
#define LW_FLAG_COTANGENT_CHART 16

// Realization with a cotangent chart: β̂(x, p) = α̂(x, −p).
#define LW_FLAG_REVERSIBLE 32

// Any part: calls on one instance may overlap in time. Whatever it says, this host makes an instance for
// each of its evaluators, and instances run in parallel.
#define LW_FLAG_SHAREABLE 64

// Dynamic approximation: the host takes y = x_k instead of solving β̂(L(y)) = x_k.
#define LW_FLAG_UNCORRECTED 128

// `LwPart.structure`: not a Poisson map, or not known to be one.
#define LW_STRUCTURE_NONE 0

// `LwPart.structure`: a Poisson map to round-off.
#define LW_STRUCTURE_EXACT -1

// The ABI's major version, also in the entry function's name: other majors do not load.
#define LW_ABI_MAJOR 1

// The ABI's minor version described here.
#define LW_ABI_MINOR 0

// The size of the part of `LwEntry` that no version changes.
#define LW_FROZEN_BYTES 24

// How a call ended: one of `LW_OK`, `LW_DISCARD`, `LW_ERROR`, `LW_FATAL`, `LW_UNSUPPORTED`; any
// other value means `LW_ERROR`.
typedef int32_t LwStatus;

// Place where a failing call says why. The caller owns it and its text buffer, and sets
// `struct_size`, `capacity`, `message` to an empty text, `point` = -1 and `ratio` = 0. The callee
// writes to it only when it returns a status other than `LW_OK`, and keeps no pointer to it.
//
// Never NULL in calls of the host to a plugin; a plugin that calls the host may pass NULL.
typedef struct LwError {
    // Bytes of this struct known to the caller.
    uint32_t struct_size;
    // Bytes at `message`, the terminating NUL included; 0 when no text is wanted.
    uint32_t capacity;
    // Room for one line of UTF-8 with a NUL at the end: what failed, at which values, what to try.
    // Longer texts are cut.
    char *message;
    // Index of the first point of the batch that failed, or -1 when that is not known.
    //
    // When it is at least 0, the output of all points before it is complete, and the host may
    // resume behind it. When it is -1, no output counts, and the host may call point by point.
    int64_t point;
    // With `LW_DISCARD`: how far the point is from the section σ over how far the domain reaches
    // there (greater than 1: outside); 0 when that is not known.
    double ratio;
} LwError;

// One vector for each point of a batch, read by the callee. Coordinate j of point i is
// `data[i * point_stride + j * coordinate_stride]`.
//
// Frozen for ABI 1.
//
// An array of points (C order, `n × dim`) has strides (dim, 1); the host's structure of arrays over
// lanes has (1, lanes). A `point_stride` of 0 gives all points the same vector. An input that a
// function does not take has `data` NULL and `dim` 0.
typedef struct LwInput {
    // The numbers; aligned for double, valid during the call.
    const double *data;
    // Coordinates of a vector.
    size_t dim;
    // Distance of neighbouring points, in doubles.
    size_t point_stride;
    // Distance of neighbouring coordinates, in doubles.
    size_t coordinate_stride;
} LwInput;

// One vector for each point of a batch, written by the callee; addressed as `LwInput` is. No two
// numbers share a place, and none is shared with an input. Nothing outside those places may be
// written, the gaps between them included. Every number of the batch is written before `LW_OK` is returned:
// the host takes what is left out as a failure. Frozen for ABI 1.
typedef struct LwOutput {
    // Room for the numbers; aligned for double, valid during the call.
    double *data;
    // Coordinates of a vector.
    size_t dim;
    // Distance of neighbouring points, in doubles.
    size_t point_stride;
    // Distance of neighbouring coordinates, in doubles.
    size_t coordinate_stride;
} LwOutput;

// One batched evaluation of a map at `count` points. The caller owns the struct and every buffer.
//
// Each function says which inputs it takes, their dimensions and that of its output. A function
// with several results writes them contiguously. Matrices are row-major: entry (r, c) of an R × C
// matrix at offset o is coordinate o + r C + c.
typedef struct LwMapCall {
    // Bytes of this struct known to the caller.
    uint32_t struct_size;
    // 0.
    uint32_t reserved;
    // The number of points; 0 is allowed and does nothing.
    size_t count;
    // The geometric parameter ε of (M, επ): positive or negative, never 0. 1 for a system.
    double epsilon;
    // The dynamic step h, positive or negative; time advances by ε h. 0 for systems and
    // realizations.
    double h;
    // The points: y or x in M (d coordinates), or z in S (d_S coordinates).
    struct LwInput point;
    // A second vector at each point, for functions that say so.
    struct LwInput v;
    // A third vector at each point, for functions that say so.
    struct LwInput w;
    // The results.
    struct LwOutput output;
} LwMapCall;

// A batched map. Its first argument is the instance, of whose calls no two overlap in time unless
// the part is `LW_FLAG_SHAREABLE`; the calling thread may change from call to call.
//
// A pure function: the result at a point depends on the instance and on that point's inputs alone.
// It allocates nothing that it does not free. A result that is not finite is a failure: the host
// checks, and takes it as `LW_ERROR`.
typedef LwStatus (*LwMapFn)(void *instance, const struct LwMapCall *call, struct LwError *err);

// The value of one parameter of a part, of the type of its declared default. Frozen for ABI 1.
typedef struct LwSetting {
    // The parameter's name.
    const char *name;
    // `LW_SETTING_INTEGER`, `LW_SETTING_REAL` or `LW_SETTING_TEXT`.
    uint32_t kind;
    // 0.
    uint32_t reserved;
    // The whole number; 0 for other kinds.
    int64_t integer;
    // The number, whole numbers included; 0 for a word.
    double real;
    // The word; NULL for numbers.
    const char *text;
} LwSetting;

// Order, structure and flags that a part promises for given parameters.
typedef struct LwProperties {
    // Bytes of this struct known to the host.
    uint32_t struct_size;
    // As `LwPart.order`.
    int32_t order;
    // As `LwPart.structure`.
    int32_t structure;
    // As `LwPart.flags`.
    uint32_t flags;
} LwProperties;

// How instances of a part are made and ended; part of every table of functions. Frozen for ABI 1.
typedef struct LwLifecycle {
    // Makes an instance and leaves it at `*instance`; on failure the host ignores `*instance`.
    // Required. A part without state may leave NULL there.
    //
    // The host makes one instance for each thread that needs one and for each set of parameter
    // values. A return of `LW_UNSUPPORTED` says that the part does not serve this system,
    // dimension or parameter. *Threads*: any, also while other instances are made or called.
    LwStatus (*create)(const struct LwCreate *args, void **instance, struct LwError *err);
    // Ends an instance: frees all that `create` and the calls made. Required. Called once, never
    // after `LW_FATAL`. *Threads*: any, after the last call on the instance has returned.
    void (*destroy)(void *instance);
    // Changes those of `properties` that depend on the parameters: the host has filled in what
    // `LwPart` declares. Optional; NULL when nothing depends on them. Called before any instance
    // exists. *Threads*: any, also while instances are made or called.
    LwStatus (*properties)(const struct LwCreate *args,
                           struct LwProperties *properties,
                           struct LwError *err);
} LwLifecycle;

// Functions of a Poisson system (M, π, H): `LW_KIND_SYSTEM`.
//
// Its parameters are those of the part (`LwPart.parameters`), fixed when an instance is made. Maps
// read `point` = y, of d coordinates; `epsilon` is 1 and `h` is 0. Threads: every function as
// `LwMapFn` says, no two calls on one instance at once unless `LW_FLAG_SHAREABLE`.
typedef struct LwSystem {
    // Bytes of this struct known to its author.
    uint32_t struct_size;
    // 0.
    uint32_t reserved;
    // How instances are made and ended.
    struct LwLifecycle life;
    // d, the dimension of M, at least 1. Required. *Threads*: as `LwMapFn`.
    size_t (*dimension)(void *instance);
    // The name of variable `index` < d; the string lives as long as the instance. Optional: NULL, or
    // a NULL result, means x1, x2, …. *Threads*: as `LwMapFn`.
    const char *(*variable_name)(void *instance, size_t index);
    // Π(y)·v, (Π v)_i = Σ_j Π_ij(y) v_j with Π_ij = {x_i, x_j}; takes `v` (d); output d. Required.
    LwMapFn tensor;
    // H(y); output 1. Required.
    LwMapFn hamiltonian;
    // ∇H(y); output d. Required.
    LwMapFn gradient;
    // The number of Casimirs, C. Optional: NULL means 0. *Threads*: as `LwMapFn`.
    size_t (*casimir_count)(void *instance);
    // The name of Casimir `index` < C in reports; the string lives as long as the instance. Required
    // where there are Casimirs. *Threads*: as `LwMapFn`.
    const char *(*casimir_name)(void *instance, size_t index);
    // All Casimirs at y; output C. Required where there are Casimirs.
    LwMapFn casimirs;
    // Their gradients; output C × d. Optional: without it Π ∇C = 0 is checked by differences.
    LwMapFn casimir_gradients;
    // The derivative of Π(y)·v along y in the direction w, Σ_jk ∂_k Π_ij(y) v_j w_k; takes `v` and
    // `w` (d each); output d. Optional: exact tangents need it.
    LwMapFn tensor_tangent;
    // D²H(y)·v; takes `v` (d); output d. Optional: exact tangents need it.
    LwMapFn hessian;
} LwSystem;

// The host's Poisson system with its parameters fixed, for a part to call. The host owns it. It is
// valid from `create` until the instance's `destroy` returns.
//
// *Threads*: call it only during a call of the host on the instance it was given to. That includes
// `create` and `destroy`. Call it on the same thread as that call. A part that is
// `LW_FLAG_SHAREABLE` may do so from several such calls at once. A status other than `LW_OK` is to
// be returned to the host.
typedef struct LwHostSystem {
    // Bytes of this struct known to the host.
    uint32_t struct_size;
    // 0; no flag is defined for systems.
    uint32_t flags;
    // The first argument of the functions.
    void *instance;
    // The functions; `life` is all NULL. The required ones are present; the optional ones are
    // present where the system is given by formulas, otherwise they may be NULL.
    const struct LwSystem *functions;
} LwHostSystem;

// Functions of realization data (S, ω, α̂_ε, β̂_ε, σ) of (M, επ): `LW_KIND_REALIZATION`.
//
// The map α̂ is a Poisson map and β̂ anti-Poisson, exactly or to the declared order n in ε, and
// α̂∘σ = β̂∘σ = id. Points z of S are flat vectors of d_S coordinates. In a cotangent chart
// (`LW_FLAG_COTANGENT_CHART`) z = (x, p) with d_S = 2 d, {x_i, p_j} = δ_ij and σ(x) = (x, 0).
//
// Maps read `point` = z except where they say x, and `epsilon`; `h` is 0. Outside the domain they
// return `LW_DISCARD`, never a number. Threads: every function as `LwMapFn` says, no two calls on
// one instance at once unless `LW_FLAG_SHAREABLE`.
typedef struct LwRealization {
    // Bytes of this struct known to its author.
    uint32_t struct_size;
    // 0.
    uint32_t reserved;
    // How instances are made and ended; `LwCreate.system` holds the tensor.
    struct LwLifecycle life;
    // d_S, the number of coordinates of a point of S. Required. *Threads*: as `LwMapFn`.
    size_t (*space_dimension)(void *instance);
    // α̂_ε(z), the end of a step; output d. Required.
    LwMapFn alpha;
    // β̂_ε(z), the start of a step; output d. Required.
    LwMapFn beta;
    // σ(x); `point` = x in M (d); output d_S. NULL means (x, 0), which needs
    // `LW_FLAG_COTANGENT_CHART`.
    LwMapFn sigma;
    // The two ends without cancellation: a base point near both (x, in a chart), β̂ − base, and α̂
    // − β̂; output 3 d. The latter two are formed directly and not as differences of the ends.
    // Optional: without it the host takes β̂, 0 and the difference α̂ − β̂, at the cost of a few
    // units of round-off a step.
    LwMapFn ends;
    // Dα̂(z); output d × d_S. Optional: collective integrators and Newton's method need it.
    LwMapFn alpha_jacobian;
    // β̂(z), then Dβ̂(z); output d + d × d_S. Optional: Newton's method needs it.
    LwMapFn beta_with_jacobian;
    // Dβ̂(z), then D(α̂ − β̂)(z), the latter without cancellation; output 2 × d × d_S. Optional:
    // preferred to the two above where all are offered, called at points where `ends` was.
    LwMapFn ends_jacobian;
    // How far z is from σ over how far the domain reaches there: less than 1 inside; output 1.
    // Optional: without it a point is inside unless a map says `LW_DISCARD`.
    LwMapFn domain;
    // The symplectic chart χ(x, p) of S about σ, χ(x, 0) = σ(x), for S whose points are not pairs
    // (x, p). Inputs `point` = x and `v` = p in ℝᵈ each; output d_S. Optional: generating
    // functions need it, or `LW_FLAG_COTANGENT_CHART`.
    LwMapFn chart;
    // Dχ(x, p); inputs as `chart`; output d_S × 2 d, the columns of x first. Optional, beside
    // `chart`.
    LwMapFn chart_jacobian;
} LwRealization;

// The host's realization, for a dynamic approximation to call. Ownership and threads as for
// `LwHostSystem`.
typedef struct LwHostRealization {
    // Bytes of this struct known to the host.
    uint32_t struct_size;
    // `LW_FLAG_EXACT`, `LW_FLAG_COTANGENT_CHART` and `LW_FLAG_REVERSIBLE`, as for the realization's
    // part.
    uint32_t flags;
    // The order n of the realization; 0 with `LW_FLAG_EXACT`.
    int32_t order;
    // 0.
    uint32_t reserved;
    // The first argument of the functions.
    void *instance;
    // The functions; `life` is all NULL. `alpha`, `beta`, `sigma`, `space_dimension` are present,
    // the others may be NULL.
    const struct LwRealization *functions;
} LwHostRealization;

// Arguments of `create` and `properties`: dimension, parameters, and the system and realization to
// serve. The host owns the struct. It and its strings are valid during the call only, but `system`
// and `realization` point to objects that stay valid until the instance's `destroy` returns.
typedef struct LwCreate {
    // Bytes of this struct known to the host.
    uint32_t struct_size;
    // 0.
    uint32_t reserved;
    // d, the dimension of M; 0 for a system, which says it itself, and in `properties` where no
    // system is chosen yet.
    size_t dim;
    // All parameters as one JSON object: `{"order": 4, "tolerance": 1e-12}`. The same values as
    // `settings`, for authors who have a JSON reader at hand.
    const char *params;
    // One setting for each entry of `LwPart.parameters`, in the same order, defaults filled in.
    const struct LwSetting *settings;
    // The number of settings.
    size_t setting_count;
    // The system to serve, its parameters fixed; NULL for a system, and in `properties` where none
    // is chosen yet.
    const struct LwHostSystem *system;
    // The realization to serve; NULL except for a dynamic approximation.
    const struct LwHostRealization *realization;
} LwCreate;

// Functions of a dynamic approximation: `LW_KIND_DYNAMICS`. It parametrizes a Lagrangian bisection
// y ↦ L_{ε,h}(y) of S that approximates φ_h^{α_ε^*H}(σ(M)) to order m in h; the host solves
// β̂(L(y)) = x_k and returns α̂(L(y)).
//
// Exactly one of `one_form`, `embedding` and `flow` is present. Maps read `epsilon`, `h` and
// `point` = y in M (d coordinates), `flow` z in S. The struct `LwCreate` holds both the system and
// the realization, which is that of the whole method. Threads: every function as `LwMapFn` says,
// no two calls on one instance at once unless `LW_FLAG_SHAREABLE`.
typedef struct LwDynamics {
    // Bytes of this struct known to its author.
    uint32_t struct_size;
    // 0.
    uint32_t reserved;
    // How instances are made and ended.
    struct LwLifecycle life;
    // θ̂_{ε,h}(y) = dŜ_{ε,h}(y), a closed one-form of M: L(y) = χ(y, θ̂(y)) in the realization's
    // cotangent chart; output d. The realization must have one, which is checked when a method is
    // composed.
    LwMapFn one_form;
    // Dθ̂(y), a symmetric matrix; output d × d. Optional, beside `one_form`: Newton's method and
    // exact tangents need it.
    LwMapFn one_form_jacobian;
    // L(y); output d_S.
    LwMapFn embedding;
    // DL(y); output d_S × d. Optional, beside `embedding`.
    LwMapFn embedding_jacobian;
    // A symplectic integrator's map Σ_{ε,h}(z) of the collective Hamiltonian H∘α̂_ε; `point` = z in S;
    // output d_S. L(y) = Σ(σ(y)).
    LwMapFn flow;
    // DΣ(z); output d_S × d_S. Optional, beside `flow`.
    LwMapFn flow_jacobian;
} LwDynamics;

// Functions of a step map Φ_{ε,h}: M → M that needs no realization: `LW_KIND_STEP_MAP`.
//
// Maps read `point` = x (d coordinates), `epsilon` and `h`; time advances by ε h, of either sign.
// Implicit maps start each solve from x alone: the result does not depend on earlier steps.
// Threads: every function as `LwMapFn` says, no two calls on one instance at once unless
// `LW_FLAG_SHAREABLE`.
typedef struct LwStepMap {
    // Bytes of this struct known to its author.
    uint32_t struct_size;
    // 0.
    uint32_t reserved;
    // How instances are made and ended.
    struct LwLifecycle life;
    // Φ(x + low) − (x + low), formed without adding x back; output d. Takes `v` = low (d), what the
    // host's compensated state holds beyond a double, less than an ulp of x: a map may ignore it,
    // and it may be absent. Required.
    LwMapFn increment;
    // DΦ(x), exact through any inner solve; output d × d. Optional: the tensor defect needs it.
    LwMapFn tangent;
} LwStepMap;

// One formula of a part, in the syntax of a scene. Frozen for ABI 1.
//
// With formulas all works for a part that works for a built-in one: exact derivatives, series,
// Hamilton–Jacobi of any order. A key is a name, or a name, a dot and the rest. The keys of each
// kind:
//
// - *System*: the keys of a scene's `[system]` table. They are `variables`: names separated by
//   commas; `families.NAME`: a length; `bracket.x1,x2`: the formula of {x1, x2};
//   `bracket.lie-algebra`: a name; `hamiltonian`; `casimirs.NAME`. And `convention`: `{H,x}` (the
//   default) or `{x,H}`; `boundary`: `periodic` or `open`. Formulas use the variables and the
//   part's numeric parameters. Their defaults stand in `LwPart.parameters`.
// - *Realization* in a cotangent chart: `alpha.1` … `alpha.d`, formulas of x1 … xd, p1 … pd and
//   `epsilon`. Further `beta.1` … `beta.d`, absent where β̂(x, p) = α̂(x, −p). Then `domain`,
//   absent where it holds everywhere: less than 1 inside.
// - *Dynamic approximation*: `S.1`, `S.3`, …, formulas of x1 … xd. These are the coefficients
//   S_l(x), l odd, of the generating function. Its formula is Ŝ_{ε,h} = Σ_l ε^{l−1} hˡ S_l.
// - *Step map*: `increment.1` … `increment.d`: Φ(x) − x, formulas of x1 … xd, `epsilon` and `h`.
//
// Realizations, dynamic approximations and step maps name the variables x1, x2, … whatever the
// system calls them, and may use their own numeric parameters. Every key occurs once.
typedef struct LwExpression {
    // Which formula.
    const char *key;
    // The formula, or the word or list the key takes.
    const char *formula;
} LwExpression;

// One parameter of a part. Frozen for ABI 1.
typedef struct LwParameter {
    // Its name in a scene: a letter, then letters, digits, `_`.
    const char *name;
    // Its meaning and its allowed values, in one line.
    const char *summary;
    // Its default as a JSON literal, which is also its type: `4` is a whole number, `4.0` or `1e-3`
    // a number, `"none"` a word. Decimal literals stay exact in formulas.
    const char *default_json;
} LwParameter;

// One part of a plugin: constant data that lives until the process ends.
//
// A part without `functions` consists of expressions alone; one with both is used by its
// expressions, its functions serving where the user asks for numbers. The two must agree.
typedef struct LwPart {
    // Bytes of this struct known to its author.
    uint32_t struct_size;
    // `LW_KIND_SYSTEM`, `LW_KIND_REALIZATION`, `LW_KIND_DYNAMICS` or `LW_KIND_STEP_MAP`.
    uint32_t kind;
    // Its name in a scene, `vendor/name`: lower-case letters, digits, `-`, and one `/`. Required.
    const char *id;
    // A description of the part, in one line. Required.
    const char *summary;
    // Its promises, in words: order, exactness, symmetry. Optional.
    const char *declares;
    // Where it is defined, in words: states, tensors, step sizes. Optional.
    const char *domain;
    // Where it is published. Optional.
    const char *reference;
    // Its parameters; NULL where there are none.
    const struct LwParameter *parameters;
    // The number of parameters.
    size_t parameter_count;
    // Its formulas; NULL where there are none.
    const struct LwExpression *expressions;
    // The number of formulas.
    size_t expression_count;
    // Its functions: the struct of its kind; NULL where it consists of expressions alone.
    const void *functions;
    // Realization: n, α̂ = α + O(ε^{n+1}). Dynamic approximation: m, in h. Step map: the order in
    // t = ε h. Lower bounds, at least 1 where they count; 0 for a system.
    int32_t order;
    // Step map: `LW_STRUCTURE_NONE`, `LW_STRUCTURE_EXACT`, or n > 0 where Φ_* π − π = O(t^{n+1}).
    // 0 for other kinds.
    int32_t structure;
    // The smallest dimension d it serves; 0 for no bound.
    uint32_t dim_min;
    // The largest dimension d it serves; 0 for no bound.
    uint32_t dim_max;
    // A sum of `LW_FLAG_…`.
    uint32_t flags;
    // 0.
    uint32_t reserved;
} LwPart;

// The plugin's list of parts, returned by the entry function: constant data that lives until the
// process ends. Its first 24 bytes, up to `part_count`, are the same in every version.
typedef struct LwEntry {
    // `LW_MAGIC`, the letters LEAFWISE.
    uint8_t magic[8];
    // `LW_ABI_MAJOR`.
    uint16_t abi_major;
    // The lowest minor version of the ABI that the plugin needs of its host: 0 where it uses nothing
    // newer, whatever header it was built with.
    uint16_t abi_minor;
    // Bytes of this struct known to its author.
    uint32_t struct_size;
    // The size of the plugin's real numbers: 8.
    uint32_t real_bytes;
    // The number of parts.
    uint32_t part_count;
    // The parts: an array of pointers, so that a part may grow.
    const struct LwPart *const *parts;
    // The plugin's own name, the `vendor` of its parts' ids. Required.
    const char *id;
    // Its version, such as `0.3.1`. Required.
    const char *version;
    // Its licence, as an SPDX expression. Optional.
    const char *license;
    // The compiler or toolchain that built it, for reports. Optional.
    const char *toolchain;
} LwEntry;

// The type of the entry function. It returns constant data, never NULL, and does nothing else.
// *Threads*: called once, on the thread that loads the plugin.
typedef const struct LwEntry *(*LwEntryFn)(void);

#ifdef __cplusplus
extern "C" {
#endif

/* A plugin defines it: constant data, never NULL. */
LW_EXPORT const LwEntry *leafwise_plugin_entry_v1(void);

#ifdef __cplusplus
}
#endif

/* Coordinate j of point i. */
static inline double lw_get(const LwInput *input, size_t i, size_t j) {
    return input->data[i * input->point_stride + j * input->coordinate_stride];
}

/* The same of an output: what a function of the host has written. */
static inline double lw_got(const LwOutput *output, size_t i, size_t j) {
    return output->data[i * output->point_stride + j * output->coordinate_stride];
}

/* Writes coordinate j of point i. */
static inline void lw_put(const LwOutput *output, size_t i, size_t j, double value) {
    output->data[i * output->point_stride + j * output->coordinate_stride] = value;
}

/* Says why point i failed (-1: not known), then returns the status: return lw_fail(…). */
static inline LwStatus lw_fail(LwError *err, LwStatus status, int64_t i, const char *message) {
    if (err) {
        err->point = i;
        if (err->message && err->capacity > 0) {
            uint32_t k = 0;
            for (; k + 1 < err->capacity && message[k]; k++) err->message[k] = message[k];
            err->message[k] = 0;
        }
    }
    return status;
}

/* Says that point i is outside the domain, how far it is from the section over how far the domain
 * reaches there (0: not known), and why: return lw_discard(…). */
static inline LwStatus lw_discard(LwError *err, int64_t i, double ratio, const char *message) {
    if (err) err->ratio = ratio;
    return lw_fail(err, LW_DISCARD, i, message);
}

/* The layout that the host reads. */
LW_STATIC_ASSERT(sizeof(LwError) == 32, "LwError has 32 bytes");
LW_STATIC_ASSERT(sizeof(LwInput) == 32, "LwInput has 32 bytes");
LW_STATIC_ASSERT(sizeof(LwOutput) == 32, "LwOutput has 32 bytes");
LW_STATIC_ASSERT(sizeof(LwMapCall) == 160, "LwMapCall has 160 bytes");
LW_STATIC_ASSERT(sizeof(LwSetting) == 40, "LwSetting has 40 bytes");
LW_STATIC_ASSERT(sizeof(LwCreate) == 56, "LwCreate has 56 bytes");
LW_STATIC_ASSERT(sizeof(LwProperties) == 16, "LwProperties has 16 bytes");
LW_STATIC_ASSERT(sizeof(LwLifecycle) == 24, "LwLifecycle has 24 bytes");
LW_STATIC_ASSERT(sizeof(LwHostSystem) == 24, "LwHostSystem has 24 bytes");
LW_STATIC_ASSERT(sizeof(LwHostRealization) == 32, "LwHostRealization has 32 bytes");
LW_STATIC_ASSERT(sizeof(LwSystem) == 120, "LwSystem has 120 bytes");
LW_STATIC_ASSERT(sizeof(LwRealization) == 120, "LwRealization has 120 bytes");
LW_STATIC_ASSERT(sizeof(LwDynamics) == 80, "LwDynamics has 80 bytes");
LW_STATIC_ASSERT(sizeof(LwStepMap) == 48, "LwStepMap has 48 bytes");
LW_STATIC_ASSERT(sizeof(LwExpression) == 16, "LwExpression has 16 bytes");
LW_STATIC_ASSERT(sizeof(LwParameter) == 24, "LwParameter has 24 bytes");
LW_STATIC_ASSERT(sizeof(LwPart) == 112, "LwPart has 112 bytes");
LW_STATIC_ASSERT(sizeof(LwEntry) == 64, "LwEntry has 64 bytes");
#endif /* LEAFWISE_PLUGIN_H */
