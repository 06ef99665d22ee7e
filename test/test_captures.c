/* test_captures.c - rays that were answered wrongly once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/capture.h"

#include <stdlib.h>

/* With every instruction set, by the oracle and by all packet widths. */
static void replay(const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", EP_CAPTURES, name);
    size_t count;
    capture *captures = read_captures(path, &count);
    assert_true(count > 0);
    for (size_t i = 0; i < count; ++i) {
        const capture *c = &captures[i];
        oracle *o = new_oracle(&c->patch, 1);
        for (const char *const *isa = epGetInstructionSets(); *isa; ++isa) {
            EPBuildSettings settings = c->settings;
            settings.isa = *isa;
            test_scene s = new_scene(&c->patch, 1, &settings);
            hits_answer *answers = malloc(c->ray_count * sizeof *answers);
            assert_non_null(answers);
            judge_rays(o, s.scene, c->rays, (unsigned)c->ray_count, answers);
            for (size_t k = 0; k < c->ray_count; ++k)
                CHECK(!answers[k].fault, "%s, patch %d, %s: %s: %s", name, (int)i, *isa, answers[k].fault,
                      ray_text(c->rays[k].org, c->rays[k].dir));
            free(answers);
            free_scene(&s);
        }
        oracle_free(o);
    }
    free_captures(captures, count);
}

static void poles(void **state)
{
    (void)state;
    replay("poles.txt");
}

static void flat(void **state)
{
    (void)state;
    replay("flat.txt");
}

static void tangents(void **state)
{
    (void)state;
    replay("tangents.txt");
}

static void coarse(void **state)
{
    (void)state;
    replay("coarse.txt");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poles),
        cmocka_unit_test(flat),
        cmocka_unit_test(tangents),
        cmocka_unit_test(coarse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
