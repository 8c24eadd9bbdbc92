/* Leafwise: Poisson integrators. Scenes, integrators, runs and their gradients, for C, C++ and all that calls C.
 *
 * Generated from the crate leafwise-c; to regenerate, in the workspace:
 *     cargo run -p leafwise-c --example header
 * Build the library by cargo build --release -p leafwise-c, and link with -lleafwise_c.
 *
 * Objects are numbers. One that was never given, or was freed, is LEAFWISE_USAGE. leafwise_free lets one go.
 * Arrays are the caller's. Element i of n numbers is data[i*stride], strides count doubles and may be negative. n is
 *   compared with the number that the scene has before anything is read or written.
 * Every function returns a LeafwiseCode, but leafwise_version and leafwise_last_error. Where it is not LEAFWISE_DONE,
 *   leafwise_last_error has the message, with places and advice.
 * Threads. Any thread may call. Different integrators step at once; one that steps in another thread is LEAFWISE_BUSY.
 * Strings are UTF-8 with a NUL at the end. */
#ifndef LEAFWISE_H
#define LEAFWISE_H


#include <stddef.h>
#include <stdint.h>

// How a call ended. Codes 0 to 3 are the program's exit codes.
typedef enum LeafwiseCode {
    // Done; all outputs are written.
    LEAFWISE_DONE = 0,
    // A step failed: diverged, left its chart, did not converge. An integrator stays at the last state that it reached.
    LEAFWISE_STEP_FAILED = 1,
    // An argument that is none: NULL, an unknown handle, a wrong length, text that is not UTF-8, a file that cannot be read.
    LEAFWISE_USAGE = 2,
    // A scene that is not valid; the message says where.
    LEAFWISE_INVALID_SCENE = 3,
    // The integrator steps in another thread.
    LEAFWISE_BUSY = 4,
    // A derivative that the scene's method does not offer, and steps of a scene whose events change the state.
    LEAFWISE_UNSUPPORTED = 5,
    // A mistake of this library.
    LEAFWISE_MISTAKE = 6,
    // Samples that find no memory.
    LEAFWISE_NO_MEMORY = 7,
} LeafwiseCode;

// Kinds of names.
typedef enum LeafwiseName {
    // A coordinate.
    LEAFWISE_COORDINATE = 0,
    // A parameter.
    LEAFWISE_PARAMETER = 1,
    // A Casimir.
    LEAFWISE_CASIMIR = 2,
} LeafwiseName;

// The number of a scene or an integrator. No number is given twice; 0 is none.
typedef uint64_t LeafwiseHandle;

// Numbers of a scene.
typedef struct LeafwiseShape {
    // d, the number of coordinates.
    size_t coordinates;
    // The number of parameters.
    size_t parameters;
    // The number of Casimirs.
    size_t casimirs;
    // The number of steps of its run.
    uint64_t steps;
    // The time of a step.
    double time_step;
} LeafwiseShape;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The library's version, as "0.1.0".
const char *leafwise_version(void);

// The message of this thread's last call, with places and advice; "" where it was done. It holds until the thread's
// next call.
const char *leafwise_last_error(void);

// Reads the scene in a file and composes its method. Scenes that name plugins are refused.
//
// Pointers:
// `file` is NULL or a string with a NUL at its end. `scene` is NULL or may be written.
enum LeafwiseCode leafwise_scene_read(const char *file, LeafwiseHandle *scene);

// The scene of a text in TOML, as a file holds it. Relative paths in it start from the current folder.
//
// Pointers:
// `toml` is NULL or a string with a NUL at its end. `scene` is NULL or may be written.
enum LeafwiseCode leafwise_scene_parse(const char *toml,
                                       LeafwiseHandle *scene);

// The same scene with one key at another value, as `--set key=value`: "method.time-step" and "0.05". The scene itself
// stays as it is.
//
// Pointers:
// `key` and `value` are NULL or strings with a NUL at their ends. `changed` is NULL or may be written.
enum LeafwiseCode leafwise_scene_set(LeafwiseHandle scene,
                                     const char *key,
                                     const char *value,
                                     LeafwiseHandle *changed);

// The numbers of coordinates, parameters, Casimirs and steps, and the time of a step.
//
// Pointers:
// `shape` is NULL or may be written.
enum LeafwiseCode leafwise_scene_shape(LeafwiseHandle scene, struct LeafwiseShape *shape);

// Writes the name of a coordinate, parameter or Casimir (a value of LeafwiseName), counted from 0, with a NUL at its end.
//
// Pointers:
// `buffer` is NULL or `capacity` bytes of it may be written.
enum LeafwiseCode leafwise_scene_name(LeafwiseHandle scene,
                                      uint32_t kind,
                                      size_t index,
                                      char *buffer,
                                      size_t capacity);

// Writes the scene's initial state, d numbers.
//
// Pointers:
// `x` is NULL, or `x[i*stride]` may be written for every i < n.
enum LeafwiseCode leafwise_scene_initial(LeafwiseHandle scene,
                                         double *x,
                                         size_t n,
                                         ptrdiff_t stride);

// Writes the values of the scene's parameters.
//
// Pointers:
// `values` is NULL, or `values[i*stride]` may be written for every i < n.
enum LeafwiseCode leafwise_scene_parameters(LeafwiseHandle scene,
                                            double *values,
                                            size_t n,
                                            ptrdiff_t stride);

// Steps from `initial`, or from the scene's own initial state where that is NULL, and writes `rows` samples of d numbers: the
// initial state, and one every so many steps. Element j of row i is at `samples[i*row_stride + j*column_stride]`. A step
// that fails writes nothing.
//
// Pointers:
// `initial` is NULL, or `initial[i*stride]` may be read for every i < n. `samples` is NULL, or all of its elements may be written.
enum LeafwiseCode leafwise_scene_run(LeafwiseHandle scene,
                                     const double *initial,
                                     size_t n,
                                     ptrdiff_t stride,
                                     uint64_t every,
                                     double *samples,
                                     size_t rows,
                                     ptrdiff_t row_stride,
                                     ptrdiff_t column_stride);

// The gradient of a function of the samples that `leafwise_scene_run` writes, exact for the map that is stepped. The
// function has the derivatives `cotangents` by them. `by_initial` gets the d derivatives by the initial state, and
// `by_parameters`, unless it is NULL, those by the m parameters.
//
// Pointers:
// As for `leafwise_scene_run`; `cotangents` may be read, `by_initial` and `by_parameters` written, where they are not NULL.
enum LeafwiseCode leafwise_scene_vjp(LeafwiseHandle scene,
                                     const double *initial,
                                     size_t n,
                                     ptrdiff_t stride,
                                     uint64_t every,
                                     const double *cotangents,
                                     size_t rows,
                                     ptrdiff_t row_stride,
                                     ptrdiff_t column_stride,
                                     double *by_initial,
                                     size_t d,
                                     ptrdiff_t by_initial_stride,
                                     double *by_parameters,
                                     size_t m,
                                     ptrdiff_t by_parameters_stride);

// A trajectory from `initial`, or from the scene's own initial state where that is NULL.
//
// Pointers:
// `initial` is NULL, or `initial[i*stride]` may be read for every i < n. `integrator` is NULL or may be written.
enum LeafwiseCode leafwise_integrator_new(LeafwiseHandle scene,
                                          const double *initial,
                                          size_t n,
                                          ptrdiff_t stride,
                                          LeafwiseHandle *integrator);

// Makes so many steps. Where one fails, the integrator stays at the state before it, and the message has its number.
enum LeafwiseCode leafwise_integrator_advance(LeafwiseHandle integrator,
                                              uint64_t steps);

// Writes the present state, d numbers.
//
// Pointers:
// `x` is NULL, or `x[i*stride]` may be written for every i < n.
enum LeafwiseCode leafwise_integrator_state(LeafwiseHandle integrator,
                                            double *x,
                                            size_t n,
                                            ptrdiff_t stride);

// The present time.
//
// Pointers:
// `t` is NULL or may be written.
enum LeafwiseCode leafwise_integrator_time(LeafwiseHandle integrator, double *t);

// The number of steps made.
//
// Pointers:
// `steps` is NULL or may be written.
enum LeafwiseCode leafwise_integrator_steps(LeafwiseHandle integrator, uint64_t *steps);

// Writes the energy and the Casimirs at the present state, 1 + casimirs numbers.
//
// Pointers:
// `values` is NULL, or `values[i*stride]` may be written for every i < n.
enum LeafwiseCode leafwise_integrator_invariants(LeafwiseHandle integrator,
                                                 double *values,
                                                 size_t n,
                                                 ptrdiff_t stride);

// Lets a scene or an integrator go. Integrators hold what they need of their scene.
enum LeafwiseCode leafwise_free(LeafwiseHandle handle);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif /* LEAFWISE_H */
