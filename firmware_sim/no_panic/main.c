/* Never run: gives the linker a root, so that all of the controller and nothing else is kept. */
extern void twinhub_new(void), twinhub_step(void);
int main(int argc, char **argv) { (argc > 1 ? twinhub_new : twinhub_step)(); return argv == 0; }
