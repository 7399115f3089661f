// Who may change something: the operator shows a token, which this tab remembers until it is closed.
import './operator.css';
import { made } from './made';

const key = 'roomfix-operator';

interface Access {
  role: 'viewer' | 'operator';
  operators: boolean; // can anything be changed at all?
}

export class Operator {
  private token = sessionStorage.getItem(key) ?? '';
  private readonly button = made('button', { id: 'operator', type: 'button', hidden: true, title: 'Whoever knows the operator\'s token may change zones' });
  private readonly dialog = made('dialog', { id: 'operator-token' });
  private readonly field = made('input', { type: 'password', required: true, autocomplete: 'off', ariaLabel: 'Operator\'s token' });
  private readonly message = made('p', { className: 'message' });

  /** `changed` is told whether whoever looks is the operator. */
  constructor(header: Element, private readonly changed: (operator: boolean) => void) {
    const form = made('form', { method: 'dialog' });
    const cancel = made('button', { type: 'button', textContent: 'Cancel' });
    const buttons = made('div', { className: 'buttons' });
    const label = made('label', { textContent: 'Operator\'s token' });
    this.message.setAttribute('role', 'alert');
    label.append(this.field);
    buttons.append(cancel, made('button', { type: 'submit', textContent: 'Enter' }));
    form.append(label, this.message, buttons);
    this.dialog.append(form);
    header.querySelector('#theme')?.before(this.button);
    document.body.append(this.dialog);
    cancel.onclick = () => this.dialog.close();
    form.onsubmit = (event) => {
      event.preventDefault();
      void this.enter(this.field.value);
    };
  }

  /** Shows the button where there can be an operator, and takes up the token of before. */
  async offer(): Promise<void> {
    const access = await this.ask();
    this.button.hidden = !access?.operators;
    if (access) this.show(access);
  }

  /** Sends a change. What is wrong with it, in words; empty if it was done. */
  async send(method: 'PUT' | 'DELETE', path: string, content?: unknown): Promise<string> {
    const headers: Record<string, string> = this.authorization();
    if (content !== undefined) headers['Content-Type'] = 'application/json';
    const answer = await fetch(path, { method, headers, body: content === undefined ? undefined : JSON.stringify(content) }).catch(() => null);
    if (!answer) return 'no connection: try again';
    return answer.ok ? '' : (await answer.text()).trim() || `the server answers ${answer.status}`;
  }

  private authorization(): Record<string, string> {
    return this.token ? { Authorization: `Bearer ${this.token}` } : {}; // without one the browser's own, if it has one
  }

  private async ask(): Promise<Access | null> {
    let answer = await fetch('api/access', { headers: this.authorization() }).catch(() => null);
    if (answer?.status === 401 && this.token) {
      this.forget();
      answer = await fetch('api/access').catch(() => null);
    }
    return answer?.ok ? ((await answer.json()) as Access) : null;
  }

  private async enter(token: string): Promise<void> {
    const before = this.token;
    this.token = token;
    const access = await this.ask();
    if (access?.role !== 'operator') {
      this.token = before;
      this.message.textContent = access ? 'This is not the operator\'s token.' : 'No connection: try again.';
      return;
    }
    sessionStorage.setItem(key, token);
    this.dialog.close();
    this.show(access);
  }

  private forget(): void {
    this.token = '';
    sessionStorage.removeItem(key);
  }

  private show(access: Access): void {
    const operator = access.role === 'operator';
    this.button.textContent = operator && this.token ? 'Sign out' : 'Operator';
    this.button.hidden = !access.operators || (operator && !this.token); // the browser itself shows the token: nothing to enter or leave
    this.button.onclick = () => {
      if (operator) {
        this.forget();
        void this.offer();
        return;
      }
      this.field.value = '';
      this.message.textContent = '';
      this.dialog.showModal();
    };
    this.changed(operator);
  }
}
