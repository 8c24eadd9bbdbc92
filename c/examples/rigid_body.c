/* A free rigid body: its states, its invariants, and the derivatives of where it ends. In this folder:
 *     cc -I../include rigid_body.c -L../../target/release -lleafwise_c -o rigid_body */
#include "leafwise.h"
#include <stdio.h>
#include <stdlib.h>

static void done(LeafwiseCode code) {
    if (code == LEAFWISE_DONE) return;
    fprintf(stderr, "%s\n", leafwise_last_error());
    exit(code);
}

static const char *body =
    "[system]\n"
    "variables   = ['x1', 'x2', 'x3']\n"
    "parameters  = { I1 = 1.0, I2 = 0.75, I3 = 1.25 }\n"
    "bracket     = { lie-algebra = 'so3' }\n"
    "hamiltonian = 'x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)'\n"
    "casimirs    = { spin = 'x1^2 + x2^2 + x3^2' }\n"
    "[method]\n"
    "realization = 'auto'\n"
    "dynamics    = { name = 'hamilton-jacobi', order = 4 }\n"
    "time-step   = 0.05\n"
    "[run]\n"
    "initial = [1, 3, 3]\n"
    "steps   = 1000\n";

int main(void) {
    LeafwiseHandle scene, integrator;
    double x[3], invariants[2], cotangents[2][3] = {{0, 0, 0}, {1, 0, 0}}, by_x0[3], by_I[3];
    done(leafwise_scene_parse(body, &scene));
    done(leafwise_integrator_new(scene, NULL, 0, 1, &integrator));
    for (int k = 0; k < 5; k++) {
        done(leafwise_integrator_advance(integrator, 200));
        done(leafwise_integrator_state(integrator, x, 3, 1));
        done(leafwise_integrator_invariants(integrator, invariants, 2, 1));
        printf("%.17g %.17g %.17g %.17g %.17g\n", x[0], x[1], x[2], invariants[0], invariants[1]);
    }
    /* The derivatives of x1 after 1000 steps, by the initial state and by I1, I2, I3. */
    done(leafwise_scene_vjp(scene, NULL, 0, 1, 1000, &cotangents[0][0], 2, 3, 1, by_x0, 3, 1, by_I, 3, 1));
    printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", by_x0[0], by_x0[1], by_x0[2], by_I[0], by_I[1], by_I[2]);
    done(leafwise_free(integrator));
    done(leafwise_free(scene));
    return 0;
}
