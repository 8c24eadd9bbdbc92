/* Arguments that are none: each call ends with its code, and outputs stay as they were. */
#include "leafwise.h"
#include <pthread.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

static void expect(int line, LeafwiseCode code, LeafwiseCode wanted, const char *words) {
    const char *message = leafwise_last_error();
    if (code == wanted && strstr(message, words) && (code != LEAFWISE_DONE || !*message)) return;
    printf("line %d: code %d in place of %d: %s\n", line, (int)code, (int)wanted, message);
    failures++;
}
#define EXPECT(call, code, words) expect(__LINE__, call, code, words)

static const char *pendulum =
    "[system]\nvariables = ['q', 'p']\nparameters = { g = 1.0 }\nbracket = 'canonical'\n"
    "hamiltonian = 'p^2/2 - g*cos(q)'\n"
    "[method]\nrealization = 'auto'\ndynamics = { name = 'hamilton-jacobi', order = 2 }\ntime-step = 0.1\n"
    "[run]\ninitial = [1, 0]\nsteps = 100\n";

static const char *escape =
    "[system]\nvariables = ['q', 'p']\nbracket = 'canonical'\nhamiltonian = 'p^2/2 - q^6'\n"
    "[method]\nstepper = 'rk4'\ntime-step = 0.1\n[run]\ninitial = [2, 3]\nsteps = 100\n";

static LeafwiseHandle shared;
static volatile int is_over = 0;

/* Steps until it was told that the integrator is another's, and once more. */
static void *steps(void *unused) {
    (void)unused;
    LeafwiseCode code = LEAFWISE_DONE;
    while (!is_over && (code == LEAFWISE_DONE || code == LEAFWISE_BUSY)) code = leafwise_integrator_advance(shared, 1000);
    return code == LEAFWISE_DONE || code == LEAFWISE_BUSY ? NULL : &shared;
}

int main(void) {
    LeafwiseHandle scene = 77, other = 0, integrator = 0;
    LeafwiseShape shape;
    double x[4] = {5, 5, 5, 5}, rows[6] = {0};
    char name[8];
    uint64_t made;

    EXPECT(leafwise_scene_parse(NULL, &scene), LEAFWISE_USAGE, "toml is NULL");
    EXPECT(leafwise_scene_parse(pendulum, NULL), LEAFWISE_USAGE, "scene is NULL");
    EXPECT(leafwise_scene_parse("\xff", &scene), LEAFWISE_USAGE, "UTF-8");
    EXPECT(leafwise_scene_parse("nothing", &scene), LEAFWISE_INVALID_SCENE, "");
    EXPECT(leafwise_scene_read("no such file.toml", &scene), LEAFWISE_USAGE, "no such file");
    if (scene != 77) failures++;
    EXPECT(leafwise_scene_parse(pendulum, &scene), LEAFWISE_DONE, "");
    EXPECT(leafwise_scene_shape(scene, &shape), LEAFWISE_DONE, "");
    if (shape.coordinates != 2 || shape.parameters != 1 || shape.casimirs != 0 || shape.steps != 100) failures++;
    EXPECT(leafwise_scene_shape(0, &shape), LEAFWISE_USAGE, "not a valid handle");
    EXPECT(leafwise_scene_shape(scene + 1000, &shape), LEAFWISE_USAGE, "not a valid handle");
    EXPECT(leafwise_scene_set(scene, "method.time-stop", "0.2", &other), LEAFWISE_INVALID_SCENE, "time-step");
    EXPECT(leafwise_scene_set(scene, "method.time-step", "0.2", &other), LEAFWISE_DONE, "");
    EXPECT(leafwise_scene_name(scene, 0, 1, name, sizeof name), LEAFWISE_DONE, "");
    if (strcmp(name, "p")) failures++;
    EXPECT(leafwise_scene_name(scene, 0, 2, name, sizeof name), LEAFWISE_USAGE, "none at 2");
    EXPECT(leafwise_scene_name(scene, 9, 0, name, sizeof name), LEAFWISE_USAGE, "LeafwiseName");
    EXPECT(leafwise_scene_name(scene, 0, 0, name, 1), LEAFWISE_USAGE, "2 bytes");
    EXPECT(leafwise_scene_name(scene, 0, 0, NULL, 8), LEAFWISE_USAGE, "NULL");

    EXPECT(leafwise_integrator_new(scene, x, 3, 1, &integrator), LEAFWISE_USAGE, "3 numbers, and the scene 2");
    EXPECT(leafwise_integrator_new(scene, x, 2, PTRDIFF_MAX, &integrator), LEAFWISE_USAGE, "outside the address space");
    x[0] = 0.0 / 0.0;
    EXPECT(leafwise_integrator_new(scene, x, 2, 1, &integrator), LEAFWISE_USAGE, "not a finite number");
    x[0] = 5;
    EXPECT(leafwise_integrator_new(scene, NULL, 0, 1, &integrator), LEAFWISE_DONE, "");
    EXPECT(leafwise_integrator_advance(scene, 1), LEAFWISE_USAGE, "is a scene");
    EXPECT(leafwise_scene_shape(integrator, &shape), LEAFWISE_USAGE, "is an integrator");
    EXPECT(leafwise_integrator_state(integrator, x, 4, 1), LEAFWISE_USAGE, "4 numbers, and the scene 2");
    EXPECT(leafwise_integrator_state(integrator, NULL, 2, 1), LEAFWISE_USAGE, "NULL");
    if (x[0] != 5 || x[1] != 5) failures++;
    /* Backwards: the second coordinate first. */
    EXPECT(leafwise_integrator_state(integrator, x + 1, 2, -1), LEAFWISE_DONE, "");
    if (x[1] != 1 || x[0] != 0) failures++;
    EXPECT(leafwise_scene_run(scene, NULL, 0, 1, 0, rows, 3, 2, 1), LEAFWISE_USAGE, "at least 1");
    EXPECT(leafwise_scene_run(scene, NULL, 0, 1, 1, NULL, 3, 2, 1), LEAFWISE_USAGE, "NULL");
    EXPECT(leafwise_scene_run(scene, NULL, 0, 1, 1, rows, SIZE_MAX / 4, 2, 1), LEAFWISE_USAGE, "outside the address space");
    /* All rows in one place: they reach nowhere, and find no room to be made in. */
    EXPECT(leafwise_scene_run(scene, NULL, 0, 1, 1, rows, SIZE_MAX / 64, 0, 1), LEAFWISE_NO_MEMORY, "");
    EXPECT(leafwise_scene_run(scene, NULL, 0, 1, 1, rows, 3, 1, 3), LEAFWISE_DONE, "");
    if (rows[0] != 1 || rows[3] != 0 || rows[1] >= 1 || rows[4] >= 0) failures++;
    EXPECT(leafwise_scene_vjp(scene, NULL, 0, 1, 1, rows, 3, 2, 1, x, 3, 1, NULL, 0, 1), LEAFWISE_USAGE, "by_initial");
    x[0] = x[1] = 7;
    EXPECT(leafwise_scene_vjp(scene, NULL, 0, 1, 1, rows, 3, 2, 1, x, 2, 1, x + 2, 2, 1), LEAFWISE_USAGE, "by_parameters");
    if (x[0] != 7 || x[1] != 7) failures++;
    EXPECT(leafwise_scene_vjp(scene, NULL, 0, 1, 1, rows, 0, 2, 1, x, 2, 1, NULL, 0, 1), LEAFWISE_USAGE, "at least 1");

    /* A motion that ends in a finite time: the integrator stays where it came. */
    EXPECT(leafwise_free(other), LEAFWISE_DONE, "");
    EXPECT(leafwise_free(other), LEAFWISE_USAGE, "was freed");
    EXPECT(leafwise_scene_parse(escape, &other), LEAFWISE_DONE, "");
    EXPECT(leafwise_free(integrator), LEAFWISE_DONE, "");
    EXPECT(leafwise_integrator_advance(integrator, 1), LEAFWISE_USAGE, "was freed");
    EXPECT(leafwise_integrator_new(other, NULL, 0, 1, &integrator), LEAFWISE_DONE, "");
    EXPECT(leafwise_integrator_advance(integrator, 1000), LEAFWISE_STEP_FAILED, "failed");
    EXPECT(leafwise_integrator_steps(integrator, &made), LEAFWISE_DONE, "");
    EXPECT(leafwise_integrator_state(integrator, x, 2, 1), LEAFWISE_DONE, "");
    if (made >= 100 || !(x[0] < 1e308)) failures++;

    /* Two threads and one integrator: one steps, the other is told to wait. A free integrator serves either. */
    pthread_t thread;
    void *ended;
    EXPECT(leafwise_integrator_new(scene, NULL, 0, 1, &shared), LEAFWISE_DONE, "");
    pthread_create(&thread, NULL, steps, NULL);
    /* However slow the machine is: until the other thread was met within its steps. */
    LeafwiseCode code;
    do {
        code = leafwise_integrator_state(shared, x, 2, 1);
        if (code != LEAFWISE_DONE && code != LEAFWISE_BUSY) failures++;
    } while (code == LEAFWISE_DONE);
    if (!strstr(leafwise_last_error(), "another thread")) failures++;
    is_over = 1;
    pthread_join(thread, &ended);
    if (ended) failures++;
    EXPECT(leafwise_integrator_state(shared, x, 2, 1), LEAFWISE_DONE, "");
    EXPECT(leafwise_integrator_steps(shared, &made), LEAFWISE_DONE, "");
    if (made == 0 || made % 1000) failures++;
    EXPECT(leafwise_free(shared), LEAFWISE_DONE, "");
    EXPECT(leafwise_free(integrator), LEAFWISE_DONE, "");
    EXPECT(leafwise_free(scene), LEAFWISE_DONE, "");
    EXPECT(leafwise_free(other), LEAFWISE_DONE, "");
    return failures;
}
